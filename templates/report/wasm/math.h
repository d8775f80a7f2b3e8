/* For WebAssembly without a C library: what the emitted C and the plants call of <math.h>. The page has them (Math, in double). */
#ifndef REPORT_MATH_H
#define REPORT_MATH_H
#define NAN __builtin_nanf("")
#define INFINITY __builtin_inff()
#define isfinite(x) __builtin_isfinite(x)
#define ONE(name) double name(double); float name##f(float);
#define TWO(name) double name(double, double); float name##f(float, float);
ONE(sqrt) ONE(exp) ONE(expm1) ONE(log) ONE(log1p) ONE(sin) ONE(cos) ONE(tan) ONE(asin) ONE(acos) ONE(atan) ONE(sinh) ONE(cosh)
ONE(tanh) ONE(asinh) ONE(acosh) ONE(atanh) ONE(fabs) ONE(floor) ONE(ceil) TWO(pow) TWO(atan2) TWO(fmin) TWO(fmax) TWO(hypot)
#undef ONE
#undef TWO
#endif
