/* waypoints.c: prescribed-time reach-avoid-stay controller, refined tube, single precision.
 *
 * Certified (waypoints.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and carries out the mission.
 * Every x(t) that stays in the tube satisfies the mission (P10): (always[0, 1] home and always[3, 4] left and
 * always[6, 7] right and always[9, 10] left and always[12, 13] right and always[17, 18] goal); times are seconds of
 * t. It still holds where every time at which the tube is in a region, or off one, is wrong by up to 0.0326 s.
 *
 * One statement a line, every value assigned once. Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
 */
#include "waypoints.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* Flags that change results are refused, before the pragma: after it avr-gcc has no macros for them. */
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "waypoints.c: compile without -ffast-math and -ffinite-math-only; it tests its inputs for NaN and infinity"
#endif
#if defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#error "waypoints.c: compile without -funsafe-math-optimizations, -fassociative-math, -freciprocal-math: they change rounding"
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 16)
#error "waypoints.c: compile for float arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif
#if defined(FLT_MANT_DIG) && (FLT_MANT_DIG != 24)
#error "waypoints.c: float is not IEEE-754's here, for which rounding is bounded"
#endif
/* No fused multiply-adds: Arduino's and other -std=gnu.. compilers would make them. */
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#pragma clang fp reassociate(off)
#elif defined(__GNUC__)
#pragma GCC optimize ("fp-contract=off")
#endif

/* B-spline control points divided by 6, one row for each of 192 + 3 points:
 * lower[0], upper[0], lower[1], upper[1]
 * Multiples of 2^-18: exact in float and double.
 */
static const waypoints_real waypoints_coefficients[780] = {
    0.6667099F, 0.8332977F, 0.6667061F, 0.8332901F,
    0.6667061F, 0.8332939F, 0.6667061F, 0.8332939F,
    0.6667023F, 0.8332901F, 0.6667099F, 0.8332939F,
    0.66669846F, 0.8332863F, 0.6667099F, 0.8332977F,
    0.6666794F, 0.8332672F, 0.6667137F, 0.8332977F,
    0.66675186F, 0.8333359F, 0.6667137F, 0.83330154F,
    0.6666565F, 0.8332405F, 0.6667175F, 0.83330154F,
    0.6667633F, 0.83335114F, 0.6667175F, 0.83330536F,
    0.66664886F, 0.8332329F, 0.66672134F, 0.83330536F,
    0.6667671F, 0.83335114F, 0.66672134F, 0.8333092F,
    0.66664505F, 0.8332329F, 0.66672516F, 0.8333092F,
    0.6667671F, 0.83335495F, 0.66672516F, 0.833313F,
    0.66664505F, 0.8332329F, 0.666729F, 0.833313F,
    0.66701126F, 0.8335991F, 0.666729F, 0.833313F,
    0.76794815F, 0.93453217F, 0.75930786F, 0.9258919F,
    0.8688812F, 1.035469F, 0.85188675F, 1.0184746F,
    0.9698181F, 1.1364021F, 0.94446564F, 1.1110535F,
    1.0707512F, 1.237339F, 1.0370445F, 1.2036324F,
    1.1716881F, 1.3382721F, 1.1296234F, 1.2962112F,
    1.2726212F, 1.439209F, 1.2222023F, 1.3887901F,
    1.3029861F, 1.469574F, 1.3147812F, 1.481369F,
    1.333355F, 1.499939F, 1.4073601F, 1.5739479F,
    1.333355F, 1.499939F, 1.499939F, 1.6665268F,
    1.333355F, 1.499939F, 1.5925179F, 1.7591057F,
    1.333355F, 1.499939F, 1.6850967F, 1.8516846F,
    1.333355F, 1.499939F, 1.7776756F, 1.9442635F,
    1.333355F, 1.499939F, 1.8702545F, 2.0368423F,
    1.333355F, 1.499939F, 1.9628334F, 2.1294212F,
    1.333355F, 1.499939F, 2.0554123F, 2.2220001F,
    1.333355F, 1.499939F, 2.1479912F, 2.314579F,
    1.333355F, 1.499939F, 2.24057F, 2.407158F,
    1.333355F, 1.499939F, 2.333149F, 2.4997368F,
    1.333355F, 1.499939F, 2.333393F, 2.499981F,
    1.333355F, 1.499939F, 2.333393F, 2.499981F,
    1.333355F, 1.499939F, 2.333393F, 2.499981F,
    1.333355F, 1.499939F, 2.333393F, 2.499981F,
    1.333355F, 1.499939F, 2.333393F, 2.499981F,
    1.333355F, 1.499939F, 2.333393F, 2.499981F,
    1.333355F, 1.499939F, 2.333393F, 2.499981F,
    1.333355F, 1.499939F, 2.333393F, 2.499981F,
    1.333355F, 1.499939F, 2.333393F, 2.499981F,
    1.333355F, 1.499939F, 2.333393F, 2.499981F,
    1.333355F, 1.499939F, 2.333393F, 2.499981F,
    1.333355F, 1.499939F, 2.333393F, 2.499981F,
    1.333355F, 1.499939F, 2.333393F, 2.499981F,
    1.3335991F, 1.5001831F, 2.333149F, 2.4997368F,
    1.3891296F, 1.5557137F, 2.2776184F, 2.4442062F,
    1.4446602F, 1.6112442F, 2.2220879F, 2.3886757F,
    1.5001907F, 1.6667747F, 2.1665573F, 2.3331451F,
    1.5557213F, 1.7223053F, 2.1110268F, 2.2776146F,
    1.6112518F, 1.7778358F, 2.0554962F, 2.2220802F,
    1.6667824F, 1.8333664F, 1.9999657F, 2.1665497F,
    1.7223129F, 1.888897F, 1.9444351F, 2.1110191F,
    1.7778435F, 1.9444275F, 1.8889046F, 2.0554886F,
    1.833374F, 1.999958F, 1.833374F, 1.999958F,
    1.8889046F, 2.0554886F, 1.7778435F, 1.9444275F,
    1.9444351F, 2.1110191F, 1.7223129F, 1.888897F,
    1.9999657F, 2.1665497F, 1.6667824F, 1.8333664F,
    2.0554962F, 2.2220802F, 1.6112518F, 1.7778358F,
    2.1110268F, 2.2776146F, 1.5557213F, 1.7223053F,
    2.1665573F, 2.3331451F, 1.5001907F, 1.6667747F,
    2.2220879F, 2.3886757F, 1.4446602F, 1.6112442F,
    2.2776184F, 2.4442062F, 1.3891296F, 1.5557137F,
    2.333149F, 2.4997368F, 1.3335991F, 1.5001831F,
    2.333393F, 2.499981F, 1.333355F, 1.499939F,
    2.333393F, 2.499981F, 1.333355F, 1.499939F,
    2.333393F, 2.499981F, 1.333355F, 1.499939F,
    2.333393F, 2.499981F, 1.333355F, 1.499939F,
    2.333393F, 2.499981F, 1.333355F, 1.499939F,
    2.333393F, 2.499981F, 1.333355F, 1.499939F,
    2.333393F, 2.499981F, 1.333355F, 1.499939F,
    2.333393F, 2.499981F, 1.333355F, 1.499939F,
    2.333393F, 2.499981F, 1.333355F, 1.499939F,
    2.333393F, 2.499981F, 1.333355F, 1.499939F,
    2.333393F, 2.499981F, 1.333355F, 1.499939F,
    2.333393F, 2.499981F, 1.333355F, 1.499939F,
    2.333393F, 2.499981F, 1.333355F, 1.499939F,
    2.333149F, 2.4997368F, 1.3335991F, 1.5001831F,
    2.2776184F, 2.4442062F, 1.3891411F, 1.5557251F,
    2.2220879F, 2.3886757F, 1.4446793F, 1.6112671F,
    2.1665573F, 2.3331451F, 1.5002213F, 1.6668091F,
    2.1110268F, 2.2776146F, 1.5557632F, 1.7223473F,
    2.0554962F, 2.2220802F, 1.6113052F, 1.7778893F,
    1.9999657F, 2.1665497F, 1.6668472F, 1.8334312F,
    1.9444351F, 2.1110191F, 1.7223892F, 1.8889732F,
    1.8889046F, 2.0554886F, 1.7779274F, 1.9445152F,
    1.833374F, 1.999958F, 1.8334694F, 2.0000572F,
    1.7778435F, 1.9444275F, 1.8890114F, 2.0555954F,
    1.7223129F, 1.888897F, 1.9445534F, 2.1111374F,
    1.6667824F, 1.8333664F, 2.0000954F, 2.1666794F,
    1.6112518F, 1.7778358F, 2.0556374F, 2.2222214F,
    1.5557213F, 1.7223053F, 2.1111755F, 2.2777634F,
    1.5001907F, 1.6667747F, 2.1667175F, 2.3333054F,
    1.4446602F, 1.6112442F, 2.2222595F, 2.3888435F,
    1.3891296F, 1.5557137F, 2.2778015F, 2.4443855F,
    1.3335991F, 1.5001831F, 2.3333435F, 2.4999275F,
    1.333355F, 1.499939F, 2.333355F, 2.499939F,
    1.333355F, 1.499939F, 2.3333664F, 2.4999504F,
    1.333355F, 1.499939F, 2.333374F, 2.4999619F,
    1.333355F, 1.499939F, 2.3333855F, 2.4999733F,
    1.333355F, 1.499939F, 2.333397F, 2.4999847F,
    1.333355F, 1.499939F, 2.333332F, 2.499916F,
    1.333355F, 1.499939F, 2.3334274F, 2.5000114F,
    1.333355F, 1.499939F, 2.3333168F, 2.4999046F,
    1.333355F, 1.499939F, 2.3334312F, 2.500019F,
    1.333355F, 1.499939F, 2.333313F, 2.4999008F,
    1.333355F, 1.499939F, 2.333435F, 2.500019F,
    1.333355F, 1.499939F, 2.333313F, 2.499897F,
    1.333355F, 1.499939F, 2.333435F, 2.500019F,
    1.3335991F, 1.5001831F, 2.3330688F, 2.4996529F,
    1.4335518F, 1.6001396F, 2.2331314F, 2.3997154F,
    1.5335083F, 1.7000923F, 2.1331902F, 2.299778F,
    1.6334648F, 1.8000488F, 2.0332527F, 2.1998367F,
    1.7334175F, 1.9000053F, 1.9333115F, 2.0998993F,
    1.833374F, 1.999958F, 1.833374F, 1.999958F,
    1.9333305F, 2.0999146F, 1.7334366F, 1.9000206F,
    2.0332832F, 2.199871F, 1.6334953F, 1.8000832F,
    2.1332397F, 2.2998238F, 1.5335579F, 1.7001419F,
    2.2331963F, 2.3997803F, 1.4336166F, 1.6002045F,
    2.333149F, 2.4997368F, 1.3336792F, 1.5002632F,
    2.333393F, 2.499981F, 1.333313F, 1.499897F,
    2.333393F, 2.499981F, 1.333435F, 1.5000191F,
    2.333393F, 2.499981F, 1.333313F, 1.499897F,
    2.333393F, 2.499981F, 1.333435F, 1.5000191F,
    2.333393F, 2.499981F, 1.3333168F, 1.4999008F,
    2.333393F, 2.499981F, 1.3334312F, 1.5000153F,
    2.333393F, 2.499981F, 1.3333206F, 1.4999046F,
    2.333393F, 2.499981F, 1.3334198F, 1.5000038F,
    2.333393F, 2.499981F, 1.3333435F, 1.4999313F,
    2.333393F, 2.499981F, 1.333374F, 1.499958F,
    2.333393F, 2.499981F, 1.3333702F, 1.499958F,
    2.333393F, 2.499981F, 1.3333702F, 1.4999542F,
    2.333393F, 2.499981F, 1.3333702F, 1.4999542F,
    2.333393F, 2.499981F, 1.3333702F, 1.4999542F,
    2.333393F, 2.499981F, 1.3333664F, 1.4999542F,
    2.333393F, 2.499981F, 1.3333664F, 1.4999504F,
    2.333393F, 2.499981F, 1.3333664F, 1.4999504F,
    2.333393F, 2.499981F, 1.3333664F, 1.4999504F,
    2.333393F, 2.499981F, 1.3333626F, 1.4999504F,
    2.333393F, 2.499981F, 1.3333626F, 1.4999466F,
    2.333393F, 2.499981F, 1.3333626F, 1.4999466F,
    2.333393F, 2.499981F, 1.3333626F, 1.4999466F,
    2.333393F, 2.499981F, 1.3333588F, 1.4999466F,
    2.333393F, 2.499981F, 1.3333588F, 1.4999428F,
    2.333393F, 2.499981F, 1.3333588F, 1.4999428F,
    2.333393F, 2.499981F, 1.3333588F, 1.4999428F,
    2.333393F, 2.499981F, 1.333355F, 1.4999428F,
    2.333393F, 2.499981F, 1.333355F, 1.499939F,
    2.333393F, 2.499981F, 1.333355F, 1.499939F,
    2.333393F, 2.499981F, 1.333355F, 1.499939F,
    2.333149F, 2.4997368F, 1.3335991F, 1.5001831F,
    2.331791F, 2.4983788F, 1.4108887F, 1.5774727F,
    2.330433F, 2.4970207F, 1.4881744F, 1.6547623F,
    2.3290749F, 2.4956627F, 1.565464F, 1.7320518F,
    2.3277168F, 2.4943047F, 1.6427536F, 1.8093376F,
    2.3263588F, 2.4929466F, 1.7200432F, 1.8866272F,
    2.3250008F, 2.4915886F, 1.7973328F, 1.9639168F,
    2.3236427F, 2.4902306F, 1.8746223F, 2.0412064F,
    2.3222847F, 2.4888725F, 1.9519081F, 2.118496F,
    2.3209267F, 2.4875145F, 2.0291977F, 2.1957817F,
    2.3195686F, 2.4861565F, 2.1064873F, 2.2730713F,
    2.3182106F, 2.4847984F, 2.1837769F, 2.3503609F,
    2.3168526F, 2.4834404F, 2.2610664F, 2.4276505F,
    2.3154945F, 2.4820824F, 2.3383522F, 2.50494F,
    2.391533F, 2.558117F, 2.4156418F, 2.5822296F,
    2.4675674F, 2.6341515F, 2.4929314F, 2.6595154F,
    2.543602F, 2.710186F, 2.570221F, 2.736805F,
    2.6196365F, 2.7862244F, 2.6475105F, 2.8140945F,
    2.695675F, 2.862259F, 2.7247963F, 2.8913841F,
    2.7717094F, 2.9382935F, 2.8020859F, 2.9686737F,
    2.847744F, 3.0143318F, 2.8793755F, 3.0459595F,
    2.9237823F, 3.0903664F, 2.956665F, 3.123249F,
    2.999817F, 3.166401F, 3.0000114F, 3.1665993F,
    3.000061F, 3.166645F, 3.000019F, 3.166607F,
    3.000061F, 3.166645F, 3.0000267F, 3.1666145F,
    3.000061F, 3.166645F, 3.0000381F, 3.1666222F,
    3.000061F, 3.166645F, 3.0000458F, 3.1666298F,
    3.000061F, 3.166645F, 3.0000534F, 3.1666374F,
    3.000061F, 3.166645F, 3.000061F, 3.166645F,
    3.000061F, 3.166645F, 3.000061F, 3.166645F,
    3.000061F, 3.166645F, 3.000061F, 3.166645F,
    3.000061F, 3.166645F, 3.000061F, 3.166645F,
    3.000061F, 3.166645F, 3.000061F, 3.166645F,
    3.000061F, 3.166645F, 3.000061F, 3.166645F,
    3.000061F, 3.166645F, 3.000061F, 3.166645F,
    3.000061F, 3.166645F, 3.000061F, 3.166645F,
    3.000061F, 3.166645F, 3.000061F, 3.166645F,
    3.000061F, 3.166645F, 3.000061F, 3.166645F,
    3.000061F, 3.166645F, 3.000061F, 3.166645F,
    3.000061F, 3.166645F, 3.000061F, 3.166645F,
    3.000061F, 3.166645F, 3.000061F, 3.166645F,
    3.000061F, 3.166645F, 3.000061F, 3.166645F,
    3.000061F, 3.166645F, 3.000061F, 3.166645F,
    3.000061F, 3.166645F, 3.000061F, 3.166645F,
    3.000061F, 3.166645F, 3.000061F, 3.166645F
};

/* Covered starts have x strictly above these bounds, by component. */
static const waypoints_real waypoints_start_lower[2] = {
    4.0052366F, 4.0052404F
};

/* Covered starts have x strictly below these bounds, by component. */
static const waypoints_real waypoints_start_upper[2] = {
    4.9947634F, 4.9947596F
};

/* Spline time u = 192 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 192 (t_c = 18 s).
 */
static inline void waypoints_segment(waypoints_real t, int32_t *row, waypoints_real *s)
{
    const bool positive = 0.0F < t;
    const waypoints_real started = positive ? t : 0.0F;
    const waypoints_real scaled = started * 10.666667F;
    const bool early = scaled < 191.99998F;
    const waypoints_real u = early ? scaled : 191.99998F;
    const int32_t segment = (int32_t)u;
    const waypoints_real base = (waypoints_real)segment;
    const waypoints_real place = u - base;
    const int32_t first = segment * 4;
    *row = first;
    *s = place;
}

/* 6 times the uniform cubic B-spline basis at s in [0, 1]: weights >= 0 with sum 6. */
static inline void waypoints_basis(waypoints_real s, waypoints_real *w0, waypoints_real *w1, waypoints_real *w2,
                                   waypoints_real *w3)
{
    const waypoints_real v0 = 1.0F - s;
    const waypoints_real v1 = v0 * v0;
    const waypoints_real v2 = v1 * v0;
    const waypoints_real v3 = v0 * s;
    const waypoints_real v4 = 1.0F + v3;
    const waypoints_real v5 = 3.0F * v4;
    const waypoints_real v6 = v0 * v5;
    const waypoints_real v7 = 1.0F + v6;
    const waypoints_real v8 = s * v5;
    const waypoints_real v9 = 1.0F + v8;
    const waypoints_real v10 = s * s;
    const waypoints_real v11 = v10 * s;
    *w0 = v2;
    *w1 = v7;
    *w2 = v9;
    *w3 = v11;
}

/* Derivative of the weights with respect to s. */
static inline void waypoints_basis_rate(waypoints_real s, waypoints_real *dw0, waypoints_real *dw1,
                                        waypoints_real *dw2, waypoints_real *dw3)
{
    const waypoints_real v0 = 1.0F - s;
    const waypoints_real v1 = v0 + v0;
    const waypoints_real v2 = v0 * v1;
    const waypoints_real v3 = v0 * v0;
    const waypoints_real v4 = v2 + v3;
    const waypoints_real v5 = -v4;
    const waypoints_real v6 = v0 - s;
    const waypoints_real v7 = 3.0F * v6;
    const waypoints_real v8 = v0 * v7;
    const waypoints_real v9 = v0 * s;
    const waypoints_real v10 = 1.0F + v9;
    const waypoints_real v11 = 3.0F * v10;
    const waypoints_real v12 = v8 - v11;
    const waypoints_real v13 = s * v7;
    const waypoints_real v14 = v11 + v13;
    const waypoints_real v15 = s + s;
    const waypoints_real v16 = s * v15;
    const waypoints_real v17 = s * s;
    const waypoints_real v18 = v16 + v17;
    *dw0 = v5;
    *dw1 = v12;
    *dw2 = v14;
    *dw3 = v18;
}

/* An edge of the tube (or its slope in spline time): sum of w_j q_j,
 * of the control points that stand at `at` and one, two and three rows after it.
 */
static inline waypoints_real waypoints_edge_at(int32_t at, waypoints_real w0, waypoints_real w1,
                                               waypoints_real w2, waypoints_real w3)
{
    const waypoints_real q0 = waypoints_coefficients[at];
    const int32_t at_1 = at + 4;
    const waypoints_real q1 = waypoints_coefficients[at_1];
    const int32_t at_2 = at + 8;
    const waypoints_real q2 = waypoints_coefficients[at_2];
    const int32_t at_3 = at + 12;
    const waypoints_real q3 = waypoints_coefficients[at_3];
    const waypoints_real v0 = w0 * q0;
    const waypoints_real v1 = w1 * q1;
    const waypoints_real v2 = v0 + v1;
    const waypoints_real v3 = w2 * q2;
    const waypoints_real v4 = w3 * q3;
    const waypoints_real v5 = v3 + v4;
    const waypoints_real v6 = v2 + v5;
    return v6;
}

/* Normalized error e = (2 x - gamma_s) / gamma_d, from a = x - lower, b = upper - x. */
static inline waypoints_real waypoints_normalized_error(waypoints_real a, waypoints_real b,
                                                        waypoints_real width)
{
    const waypoints_real v0 = a - b;
    const waypoints_real v1 = v0 / width;
    return v1;
}

/* Transformed error epsilon = ln((1 + e)/(1 - e)) = ln(a/b) and xi = d epsilon/dx = 1/a + 1/b. */
static inline void waypoints_transformed_error(waypoints_real a, waypoints_real b, waypoints_real *epsilon,
                                               waypoints_real *xi)
{
    const waypoints_real v0 = b / a;
    const waypoints_real v1 = logf(v0);
    const waypoints_real v2 = -v1;
    const waypoints_real v3 = 1.0F + v0;
    const waypoints_real v4 = v3 / b;
    *epsilon = v2;
    *xi = v4;
}

/* Control law (13): u = -k xi epsilon. */
static inline waypoints_real waypoints_law(waypoints_real k, waypoints_real xi, waypoints_real epsilon)
{
    const waypoints_real v0 = k * xi;
    const waypoints_real v1 = v0 * epsilon;
    const waypoints_real v2 = -v1;
    return v2;
}

void waypoints_tube(waypoints_real t, waypoints_real lower[WAYPOINTS_N], waypoints_real upper[WAYPOINTS_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower[j] = (waypoints_real)NAN;
            upper[j] = (waypoints_real)NAN;
        }
        return;
    }
    int32_t row;
    waypoints_real s;
    waypoints_segment(t, &row, &s);
    waypoints_real w0;
    waypoints_real w1;
    waypoints_real w2;
    waypoints_real w3;
    waypoints_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const waypoints_real lower_edge = waypoints_edge_at(lower_at, w0, w1, w2, w3);
        const waypoints_real upper_edge = waypoints_edge_at(upper_at, w0, w1, w2, w3);
        lower[i] = lower_edge;
        upper[i] = upper_edge;
    }
}

void waypoints_tube_rate(waypoints_real t, waypoints_real lower_rate[WAYPOINTS_N],
                         waypoints_real upper_rate[WAYPOINTS_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower_rate[j] = (waypoints_real)NAN;
            upper_rate[j] = (waypoints_real)NAN;
        }
        return;
    }
    int32_t row;
    waypoints_real s;
    waypoints_segment(t, &row, &s);
    waypoints_real dw0;
    waypoints_real dw1;
    waypoints_real dw2;
    waypoints_real dw3;
    waypoints_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    const bool moving = t < 18.0F;
    const waypoints_real per_second = moving ? 10.666667F : 0.0F;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const waypoints_real lower_slope = waypoints_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const waypoints_real lower_speed = lower_slope * per_second;
        const waypoints_real upper_slope = waypoints_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const waypoints_real upper_speed = upper_slope * per_second;
        lower_rate[i] = lower_speed;
        upper_rate[i] = upper_speed;
    }
}

waypoints_status waypoints_control(waypoints_real t, const waypoints_real x[WAYPOINTS_N],
                                   waypoints_real u[WAYPOINTS_N])
{
    const waypoints_real t_zero = t * 0.0F;
    waypoints_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const waypoints_real x_j = x[j];
        const waypoints_real x_zero = x_j * 0.0F;
        const waypoints_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 2; ++m) {
            u[m] = 0.0F;
        }
        return WAYPOINTS_BAD_INPUT;
    }
    int32_t row;
    waypoints_real s;
    waypoints_segment(t, &row, &s);
    waypoints_real w0;
    waypoints_real w1;
    waypoints_real w2;
    waypoints_real w3;
    waypoints_basis(s, &w0, &w1, &w2, &w3);
    bool outside = false;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const waypoints_real lower_edge = waypoints_edge_at(lower_at, w0, w1, w2, w3);
        const waypoints_real upper_edge = waypoints_edge_at(upper_at, w0, w1, w2, w3);
        const waypoints_real x_i = x[i];
        const waypoints_real width = upper_edge - lower_edge;
        const waypoints_real to_lower = x_i - lower_edge;
        const waypoints_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const waypoints_real distance = upper_nearer ? to_upper : to_lower;
        const waypoints_real gain = upper_nearer ? (-0.5F) : 0.5F;
        const waypoints_real smallest = width * 0.005F;
        const bool clear = smallest < distance;
        const waypoints_real to_nearer = clear ? distance : smallest;
        const waypoints_real to_farther = width - to_nearer;
        const bool inside = 0.0F < distance;
        const bool outside_next = inside ? outside : true;
        waypoints_real epsilon;
        waypoints_real xi;
        waypoints_transformed_error(to_nearer, to_farther, &epsilon, &xi);
        const waypoints_real u_i = waypoints_law(gain, xi, epsilon);
        u[i] = u_i;
        outside = outside_next;
    }
    return outside ? WAYPOINTS_OUTSIDE_TUBE : WAYPOINTS_OK;
}

waypoints_real waypoints_margin(waypoints_real t, const waypoints_real x[WAYPOINTS_N])
{
    const waypoints_real t_zero = t * 0.0F;
    waypoints_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const waypoints_real x_j = x[j];
        const waypoints_real x_zero = x_j * 0.0F;
        const waypoints_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        return (waypoints_real)NAN;
    }
    int32_t row;
    waypoints_real s;
    waypoints_segment(t, &row, &s);
    waypoints_real w0;
    waypoints_real w1;
    waypoints_real w2;
    waypoints_real w3;
    waypoints_basis(s, &w0, &w1, &w2, &w3);
    waypoints_real margin = 0.5F;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const waypoints_real lower_edge = waypoints_edge_at(lower_at, w0, w1, w2, w3);
        const waypoints_real upper_edge = waypoints_edge_at(upper_at, w0, w1, w2, w3);
        const waypoints_real x_i = x[i];
        const waypoints_real width = upper_edge - lower_edge;
        const waypoints_real to_lower = x_i - lower_edge;
        const waypoints_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const waypoints_real x_distance = x_nearer ? to_upper : to_lower;
        const waypoints_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0F);
        const waypoints_real margin_x = x_beyond ? (-1.0F) : x_share;
        const bool less = margin_x < margin;
        const waypoints_real margin_next = less ? margin_x : margin;
        margin = margin_next;
    }
    return margin;
}

void waypoints_margins(waypoints_real t, const waypoints_real x[WAYPOINTS_N],
                       waypoints_real margin[WAYPOINTS_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            margin[j] = (waypoints_real)NAN;
        }
        return;
    }
    int32_t row;
    waypoints_real s;
    waypoints_segment(t, &row, &s);
    waypoints_real w0;
    waypoints_real w1;
    waypoints_real w2;
    waypoints_real w3;
    waypoints_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const waypoints_real lower_edge = waypoints_edge_at(lower_at, w0, w1, w2, w3);
        const waypoints_real upper_edge = waypoints_edge_at(upper_at, w0, w1, w2, w3);
        const waypoints_real x_i = x[i];
        const waypoints_real width = upper_edge - lower_edge;
        const waypoints_real to_lower = x_i - lower_edge;
        const waypoints_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const waypoints_real x_distance = x_nearer ? to_upper : to_lower;
        const waypoints_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0F);
        const waypoints_real margin_x = x_beyond ? (-1.0F) : x_share;
        margin[i] = margin_x;
    }
}

bool waypoints_covered(const waypoints_real x[WAYPOINTS_N])
{
    bool covered = true;
    for (int32_t i = 0; i < 2; ++i) {
        const waypoints_real x_i = x[i];
        const waypoints_real x_lower = waypoints_start_lower[i];
        const waypoints_real x_upper = waypoints_start_upper[i];
        const bool x_above = x_lower < x_i;
        const bool x_below = x_i < x_upper;
        const bool x_inside = x_above && x_below;
        const bool covered_next = x_inside ? covered : false;
        covered = covered_next;
    }
    return covered;
}

void waypoints_transform(const waypoints_real lower[WAYPOINTS_N], const waypoints_real upper[WAYPOINTS_N],
                         const waypoints_real x[WAYPOINTS_N], waypoints_real e[WAYPOINTS_N],
                         waypoints_real epsilon[WAYPOINTS_N], waypoints_real xi[WAYPOINTS_N])
{
    for (int32_t i = 0; i < 2; ++i) {
        const waypoints_real lower_edge = lower[i];
        const waypoints_real upper_edge = upper[i];
        const waypoints_real x_i = x[i];
        const waypoints_real width = upper_edge - lower_edge;
        const bool filled = 0.0F < width;
        const bool empty = !filled;
        const bool wide = 9.536743e-7F < width;
        const waypoints_real safe_width = wide ? width : 9.536743e-7F;
        const waypoints_real to_lower = x_i - lower_edge;
        const waypoints_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const waypoints_real distance = upper_nearer ? to_upper : to_lower;
        const waypoints_real sign = upper_nearer ? (-1.0F) : 1.0F;
        const waypoints_real smallest = safe_width * 0.005F;
        const waypoints_real widened = safe_width - width;
        const waypoints_real half = widened * 0.5F;
        const waypoints_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const waypoints_real to_nearer = clear ? safe_distance : smallest;
        const waypoints_real to_farther = safe_width - to_nearer;
        const waypoints_real a = upper_nearer ? to_farther : to_nearer;
        const waypoints_real b = upper_nearer ? to_nearer : to_farther;
        const waypoints_real e_i = waypoints_normalized_error(a, b, safe_width);
        const bool e_above = (-0.99F) < e_i;
        const waypoints_real e_raised = e_above ? e_i : (-0.99F);
        const bool e_beyond = 0.99F < e_raised;
        const waypoints_real e_limited = e_beyond ? 0.99F : e_raised;
        waypoints_real epsilon_nearer;
        waypoints_real xi_i;
        waypoints_transformed_error(to_nearer, to_farther, &epsilon_nearer, &xi_i);
        const waypoints_real epsilon_i = sign * epsilon_nearer;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_width = isfinite(width) != 0;
        const bool finite = finite_x && finite_width;
        const waypoints_real e_or_zero = empty ? 0.0F : e_limited;
        const waypoints_real e_out = finite ? e_or_zero : (waypoints_real)NAN;
        e[i] = e_out;
        const waypoints_real epsilon_or_zero = empty ? 0.0F : epsilon_i;
        const waypoints_real epsilon_out = finite ? epsilon_or_zero : (waypoints_real)NAN;
        epsilon[i] = epsilon_out;
        const waypoints_real xi_or_zero = empty ? 0.0F : xi_i;
        const waypoints_real xi_out = finite ? xi_or_zero : (waypoints_real)NAN;
        xi[i] = xi_out;
    }
}
