/* For WebAssembly without a C library: the functions of <math.h> that the emitted C and plants call. The page imports them from Math, in double. */
#ifndef REPORT_MATH_H
#define REPORT_MATH_H
#define NAN __builtin_nanf("")
#define INFINITY __builtin_inff()
#define isfinite(x) __builtin_isfinite(x)
#define UNARY(name) double name(double); float name##f(float);
#define BINARY(name) double name(double, double); float name##f(float, float);
UNARY(sqrt) UNARY(exp) UNARY(expm1) UNARY(log) UNARY(log1p) UNARY(sin) UNARY(cos) UNARY(tan) UNARY(asin) UNARY(acos) UNARY(atan) UNARY(sinh) UNARY(cosh)
UNARY(tanh) UNARY(asinh) UNARY(acosh) UNARY(atanh) UNARY(fabs) UNARY(floor) UNARY(ceil) BINARY(pow) BINARY(atan2) BINARY(fmin) BINARY(fmax) BINARY(hypot)
#undef UNARY
#undef BINARY
#endif
