/* omni_s2.c: prescribed-time reach-avoid-stay controller, literal tube, single precision.
 *
 * *** NOT CERTIFIED *** NOT CERTIFIED *** NOT CERTIFIED ***
 * This controller was written with --uncertified. Do not run it on a machine. What fails:
 *   P1 width at t = 0.91125 s, dimension 1
 *   P4 avoid at t in [0.91125, 0.9135] s, unsafe set O3
 *   P5 reach at t = 9 s, dimension 2
 *
 * One statement a line, every value assigned once. Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
 */
#include "omni_s2.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* Flags that change results are refused, before the pragma: after it avr-gcc has no macros for them. */
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "omni_s2.c: compile without -ffast-math and -ffinite-math-only; it tests its inputs for NaN and infinity"
#endif
#if defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#error "omni_s2.c: compile without -funsafe-math-optimizations, -fassociative-math, -freciprocal-math: they change rounding"
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 16)
#error "omni_s2.c: compile for float arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif
#if defined(FLT_MANT_DIG) && (FLT_MANT_DIG != 24)
#error "omni_s2.c: float is not IEEE-754's here, for which rounding is bounded"
#endif
/* No fused multiply-adds: Arduino's and other -std=gnu.. compilers would make them. */
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#pragma clang fp reassociate(off)
#elif defined(__GNUC__)
#pragma GCC optimize ("fp-contract=off")
#endif

/* By dimension: X0hat and That of the lower edge, X0hat and That of the upper edge. */
static const omni_s2_real omni_s2_reach[8] = {
    0.0F, 4.5F, 0.5F, 5.0F,
    0.0F, 4.5F, 0.5F, 5.0F
};

/* By dimension: rest levels of beta_L and beta_U. */
static const omni_s2_real omni_s2_walls[4] = {
    0.0F, 5.0F,
    0.0F, 5.0F
};

/* Circumvent functions B, k, m, r: for each dimension 1 of beta_L, then 1 of beta_U,
 * filled up with height 0.
 */
static const omni_s2_real omni_s2_bumps[16] = {
    2.2F, 0.01F, 1.6098633F, 0.7065067F,
    0.0F, 1.0F, 0.0F, 1.0F,
    0.0F, 1.0F, 0.0F, 1.0F,
    2.7F, 0.01F, 3.46138F, 0.55169487F
};

/* t held within [0, t_c]. */
static inline omni_s2_real omni_s2_hold(omni_s2_real t, omni_s2_real t_c)
{
    const bool positive = 0.0F < t;
    const omni_s2_real started = positive ? t : 0.0F;
    const bool running = started < t_c;
    const omni_s2_real held = running ? started : t_c;
    return held;
}

/* Time profile of (4): sigma = tanh(t / (t_c - t)), 1 from t_c on. */
static inline omni_s2_real omni_s2_profile(omni_s2_real t, omni_s2_real t_c)
{
    const omni_s2_real v0 = t_c - t;
    const omni_s2_real v1 = 0.0009765625F * t_c;
    const bool v2 = v1 < v0;
    const omni_s2_real v3 = v2 ? v0 : v1;
    const omni_s2_real v4 = t / v3;
    const omni_s2_real v5 = (-2.0F) * v4;
    const omni_s2_real v6 = expf(v5);
    const omni_s2_real v7 = 1.0F - v6;
    const omni_s2_real v8 = 1.0F + v6;
    const omni_s2_real v9 = v7 / v8;
    return v9;
}

/* sigma of (4) and its derivative. */
static inline void omni_s2_profile_rate(omni_s2_real t, omni_s2_real t_c, omni_s2_real *sigma,
                                        omni_s2_real *sigma_rate)
{
    const omni_s2_real v0 = t_c - t;
    const omni_s2_real v1 = 0.0009765625F * t_c;
    const bool v2 = v1 < v0;
    const omni_s2_real v3 = v2 ? v0 : v1;
    const omni_s2_real v4 = t / v3;
    const omni_s2_real v5 = (-2.0F) * v4;
    const omni_s2_real v6 = expf(v5);
    const omni_s2_real v7 = 1.0F - v6;
    const omni_s2_real v8 = 1.0F + v6;
    const omni_s2_real v9 = v7 / v8;
    const omni_s2_real v10 = 1.0F / v3;
    const omni_s2_real v11 = v4 / v3;
    const bool v12 = v1 <= v0;
    const bool v13 = v0 <= v1;
    const omni_s2_real v14 = v12 ? 1.0F : 0.0F;
    const omni_s2_real v15 = v13 ? 1.0F : 0.0F;
    const omni_s2_real v16 = v14 + v15;
    const omni_s2_real v17 = v14 / v16;
    const omni_s2_real v18 = v11 * v17;
    const omni_s2_real v19 = v10 + v18;
    const omni_s2_real v20 = (-2.0F) * v19;
    const omni_s2_real v21 = v6 * v20;
    const omni_s2_real v22 = v21 / v8;
    const omni_s2_real v23 = v9 / v8;
    const omni_s2_real v24 = v23 * v21;
    const omni_s2_real v25 = v22 + v24;
    const omni_s2_real v26 = -v25;
    *sigma = v9;
    *sigma_rate = v26;
}

/* An edge of the reachability tube (4). */
static inline omni_s2_real omni_s2_reach_edge(omni_s2_real start, omni_s2_real end, omni_s2_real sigma)
{
    const omni_s2_real v0 = end - start;
    const omni_s2_real v1 = v0 * sigma;
    const omni_s2_real v2 = start + v1;
    return v2;
}

/* The rate of an edge of the reachability tube (4). */
static inline omni_s2_real omni_s2_reach_rate(omni_s2_real start, omni_s2_real end, omni_s2_real sigma_rate)
{
    const omni_s2_real v0 = end - start;
    const omni_s2_real v1 = v0 * sigma_rate;
    return v1;
}

/* A circumvent function (7), (8) above its rest level. */
static inline omni_s2_real omni_s2_circumvent(omni_s2_real t, omni_s2_real height, omni_s2_real steepness,
                                              omni_s2_real middle, omni_s2_real radius, omni_s2_real cut)
{
    const omni_s2_real v0 = t - middle;
    const omni_s2_real v1 = v0 * v0;
    const omni_s2_real v2 = steepness * v1;
    const omni_s2_real v3 = fabsf(v0);
    const omni_s2_real v4 = radius - v3;
    const omni_s2_real v5 = radius + v3;
    const omni_s2_real v6 = v4 * v5;
    const omni_s2_real v7 = v2 * cut;
    const bool v8 = v7 < v6;
    const omni_s2_real v9 = v8 ? v6 : v7;
    const omni_s2_real v10 = v2 / v9;
    const omni_s2_real v11 = -v10;
    const omni_s2_real v12 = expf(v11);
    const omni_s2_real v13 = height * v12;
    return v13;
}

/* A circumvent function (7), (8) and its derivative. */
static inline void omni_s2_circumvent_rate(omni_s2_real t, omni_s2_real height, omni_s2_real steepness,
                                           omni_s2_real middle, omni_s2_real radius, omni_s2_real cut,
                                           omni_s2_real *bump, omni_s2_real *bump_rate)
{
    const omni_s2_real v0 = t - middle;
    const omni_s2_real v1 = v0 * v0;
    const omni_s2_real v2 = steepness * v1;
    const omni_s2_real v3 = fabsf(v0);
    const omni_s2_real v4 = radius - v3;
    const omni_s2_real v5 = radius + v3;
    const omni_s2_real v6 = v4 * v5;
    const omni_s2_real v7 = v2 * cut;
    const bool v8 = v7 < v6;
    const omni_s2_real v9 = v8 ? v6 : v7;
    const omni_s2_real v10 = v2 / v9;
    const omni_s2_real v11 = -v10;
    const omni_s2_real v12 = expf(v11);
    const omni_s2_real v13 = height * v12;
    const omni_s2_real v14 = v0 + v0;
    const omni_s2_real v15 = steepness * v14;
    const omni_s2_real v16 = v15 / v9;
    const omni_s2_real v17 = v10 / v9;
    const bool v18 = v7 <= v6;
    const bool v19 = v6 <= v7;
    const omni_s2_real v20 = v18 ? 1.0F : 0.0F;
    const omni_s2_real v21 = v19 ? 1.0F : 0.0F;
    const omni_s2_real v22 = v20 + v21;
    const omni_s2_real v23 = v20 / v22;
    const bool v24 = v0 < 0.0F;
    const omni_s2_real v25 = v24 ? (-1.0F) : 0.0F;
    const bool v26 = 0.0F < v0;
    const omni_s2_real v27 = v26 ? 1.0F : v25;
    const omni_s2_real v28 = v4 * v27;
    const omni_s2_real v29 = v5 * v27;
    const omni_s2_real v30 = v28 - v29;
    const omni_s2_real v31 = v23 * v30;
    const omni_s2_real v32 = v21 / v22;
    const omni_s2_real v33 = cut * v15;
    const omni_s2_real v34 = v32 * v33;
    const omni_s2_real v35 = v31 + v34;
    const omni_s2_real v36 = v17 * v35;
    const omni_s2_real v37 = v16 - v36;
    const omni_s2_real v38 = v12 * v37;
    const omni_s2_real v39 = height * v38;
    const omni_s2_real v40 = -v39;
    *bump = v13;
    *bump_rate = v40;
}

/* The update function's equation (11) and its exact Jacobian. */
static inline void omni_s2_update_rate(omni_s2_real psi, omni_s2_real alpha, omni_s2_real theta0,
                                       omni_s2_real kappa, omni_s2_real mu, omni_s2_real varsigma,
                                       omni_s2_real *alpha_rate, omni_s2_real *jacobian)
{
    const omni_s2_real v0 = theta0 + theta0;
    const omni_s2_real v1 = psi - mu;
    const omni_s2_real v2 = varsigma * v1;
    const bool v3 = v2 < 40.0F;
    const omni_s2_real v4 = v3 ? v2 : 40.0F;
    const omni_s2_real v5 = v4 + v4;
    const omni_s2_real v6 = expf(v5);
    const omni_s2_real v7 = 1.0F + v6;
    const omni_s2_real v8 = v0 / v7;
    const omni_s2_real v9 = psi + alpha;
    const bool v10 = 9.313226e-10F < v9;
    const omni_s2_real v11 = v10 ? v9 : 9.313226e-10F;
    const omni_s2_real v12 = v8 / v11;
    const omni_s2_real v13 = v12 / v11;
    const omni_s2_real v14 = kappa * alpha;
    const omni_s2_real v15 = v13 - v14;
    const bool v16 = 9.313226e-10F <= v9;
    const bool v17 = v9 <= 9.313226e-10F;
    const omni_s2_real v18 = v16 ? 1.0F : 0.0F;
    const omni_s2_real v19 = v17 ? 1.0F : 0.0F;
    const omni_s2_real v20 = v18 + v19;
    const omni_s2_real v21 = v18 / v20;
    const omni_s2_real v22 = v13 * v21;
    const omni_s2_real v23 = v22 / v11;
    const omni_s2_real v24 = v13 / v11;
    const omni_s2_real v25 = v24 * v21;
    const omni_s2_real v26 = v23 + v25;
    const omni_s2_real v27 = v26 + kappa;
    const omni_s2_real v28 = -v27;
    *alpha_rate = v15;
    *jacobian = v28;
}

/* Implicit step of (11): (z - p) z^2 = q, and where to start. */
static inline void omni_s2_implicit_start(omni_s2_real psi, omni_s2_real alpha, omni_s2_real h,
                                          omni_s2_real theta0, omni_s2_real kappa, omni_s2_real mu,
                                          omni_s2_real varsigma, omni_s2_real *p, omni_s2_real *q,
                                          omni_s2_real *rest, omni_s2_real *z)
{
    const omni_s2_real v0 = h * kappa;
    const omni_s2_real v1 = 1.0F + v0;
    const omni_s2_real v2 = alpha / v1;
    const omni_s2_real v3 = psi + v2;
    const omni_s2_real v4 = theta0 + theta0;
    const omni_s2_real v5 = psi - mu;
    const omni_s2_real v6 = varsigma * v5;
    const bool v7 = v6 < 40.0F;
    const omni_s2_real v8 = v7 ? v6 : 40.0F;
    const omni_s2_real v9 = v8 + v8;
    const omni_s2_real v10 = expf(v9);
    const omni_s2_real v11 = 1.0F + v10;
    const omni_s2_real v12 = v4 / v11;
    const omni_s2_real v13 = h * v12;
    const omni_s2_real v14 = v13 / v1;
    const bool v15 = v3 < 0.0F;
    const omni_s2_real v16 = powf(v14, 0.33333334F);
    const omni_s2_real v17 = -v3;
    const bool v18 = 8.6736174e-19F < v17;
    const omni_s2_real v19 = v18 ? v17 : 8.6736174e-19F;
    const omni_s2_real v20 = v14 / v19;
    const omni_s2_real v21 = sqrtf(v20);
    const bool v22 = v16 < v21;
    const omni_s2_real v23 = v22 ? v16 : v21;
    const omni_s2_real v24 = v15 ? v23 : 0.0F;
    const bool v25 = !v15;
    const omni_s2_real v26 = v3 + v16;
    const omni_s2_real v27 = v25 ? v26 : 0.0F;
    const omni_s2_real v28 = v24 + v27;
    const bool v29 = 8.6736174e-19F < v28;
    const omni_s2_real v30 = v29 ? v28 : 8.6736174e-19F;
    *p = v3;
    *q = v14;
    *rest = v2;
    *z = v30;
}

/* One Newton iterate for (z - p) z^2 = q. */
static inline omni_s2_real omni_s2_newton(omni_s2_real p, omni_s2_real q, omni_s2_real z)
{
    const omni_s2_real v0 = z - p;
    const omni_s2_real v1 = v0 * z;
    const omni_s2_real v2 = v1 * z;
    const omni_s2_real v3 = v2 - q;
    const omni_s2_real v4 = z + v0;
    const omni_s2_real v5 = z * v4;
    const omni_s2_real v6 = v5 + v1;
    const omni_s2_real v7 = v3 / v6;
    const omni_s2_real v8 = z - v7;
    const bool v9 = 8.6736174e-19F < v8;
    const omni_s2_real v10 = v9 ? v8 : 8.6736174e-19F;
    return v10;
}

/* Implicit step of (11): alpha from the root z = psi + alpha. */
static inline omni_s2_real omni_s2_implicit_end(omni_s2_real q, omni_s2_real rest, omni_s2_real z)
{
    const omni_s2_real v0 = z * z;
    const omni_s2_real v1 = q / v0;
    const omni_s2_real v2 = rest + v1;
    return v2;
}

/* gamma_L of (10). */
static inline omni_s2_real omni_s2_lower_edge(omni_s2_real rho, omni_s2_real alpha, omni_s2_real beta,
                                              omni_s2_real nu)
{
    const omni_s2_real v0 = rho - alpha;
    const omni_s2_real v1 = v0 + beta;
    const omni_s2_real v2 = v1 / 2.0F;
    const omni_s2_real v3 = v0 - beta;
    const omni_s2_real v4 = fabsf(v3);
    const omni_s2_real v5 = v4 / 2.0F;
    const omni_s2_real v6 = v2 + v5;
    const omni_s2_real v7 = (-2.0F) * nu;
    const omni_s2_real v8 = v7 * v5;
    const omni_s2_real v9 = expf(v8);
    const omni_s2_real v10 = log1pf(v9);
    const omni_s2_real v11 = v10 / nu;
    const omni_s2_real v12 = v6 + v11;
    return v12;
}

/* gamma_L of (10) and its total rate. */
static inline void omni_s2_lower_edge_rate(omni_s2_real rho, omni_s2_real alpha, omni_s2_real beta,
                                           omni_s2_real nu, omni_s2_real rho_rate, omni_s2_real alpha_rate,
                                           omni_s2_real beta_rate, omni_s2_real *gamma,
                                           omni_s2_real *gamma_rate)
{
    const omni_s2_real v0 = rho - alpha;
    const omni_s2_real v1 = v0 + beta;
    const omni_s2_real v2 = v1 / 2.0F;
    const omni_s2_real v3 = v0 - beta;
    const omni_s2_real v4 = fabsf(v3);
    const omni_s2_real v5 = v4 / 2.0F;
    const omni_s2_real v6 = v2 + v5;
    const omni_s2_real v7 = (-2.0F) * nu;
    const omni_s2_real v8 = v7 * v5;
    const omni_s2_real v9 = expf(v8);
    const omni_s2_real v10 = log1pf(v9);
    const omni_s2_real v11 = v10 / nu;
    const omni_s2_real v12 = v6 + v11;
    const omni_s2_real v13 = rho_rate - alpha_rate;
    const omni_s2_real v14 = v13 + beta_rate;
    const omni_s2_real v15 = 0.5F * v14;
    const bool v16 = v3 < 0.0F;
    const omni_s2_real v17 = v16 ? (-1.0F) : 0.0F;
    const bool v18 = 0.0F < v3;
    const omni_s2_real v19 = v18 ? 1.0F : v17;
    const omni_s2_real v20 = v13 - beta_rate;
    const omni_s2_real v21 = v19 * v20;
    const omni_s2_real v22 = 0.5F * v21;
    const omni_s2_real v23 = v15 + v22;
    const omni_s2_real v24 = v7 * v22;
    const omni_s2_real v25 = v9 * v24;
    const omni_s2_real v26 = 1.0F + v9;
    const omni_s2_real v27 = v25 / v26;
    const omni_s2_real v28 = v27 / nu;
    const omni_s2_real v29 = v23 + v28;
    *gamma = v12;
    *gamma_rate = v29;
}

/* gamma_U of (10). */
static inline omni_s2_real omni_s2_upper_edge(omni_s2_real rho, omni_s2_real alpha, omni_s2_real beta,
                                              omni_s2_real nu)
{
    const omni_s2_real v0 = rho + alpha;
    const omni_s2_real v1 = v0 + beta;
    const omni_s2_real v2 = v1 / 2.0F;
    const omni_s2_real v3 = v0 - beta;
    const omni_s2_real v4 = fabsf(v3);
    const omni_s2_real v5 = v4 / 2.0F;
    const omni_s2_real v6 = v2 - v5;
    const omni_s2_real v7 = (-2.0F) * nu;
    const omni_s2_real v8 = v7 * v5;
    const omni_s2_real v9 = expf(v8);
    const omni_s2_real v10 = log1pf(v9);
    const omni_s2_real v11 = v10 / nu;
    const omni_s2_real v12 = v6 - v11;
    return v12;
}

/* gamma_U of (10) and its total rate. */
static inline void omni_s2_upper_edge_rate(omni_s2_real rho, omni_s2_real alpha, omni_s2_real beta,
                                           omni_s2_real nu, omni_s2_real rho_rate, omni_s2_real alpha_rate,
                                           omni_s2_real beta_rate, omni_s2_real *gamma,
                                           omni_s2_real *gamma_rate)
{
    const omni_s2_real v0 = rho + alpha;
    const omni_s2_real v1 = v0 + beta;
    const omni_s2_real v2 = v1 / 2.0F;
    const omni_s2_real v3 = v0 - beta;
    const omni_s2_real v4 = fabsf(v3);
    const omni_s2_real v5 = v4 / 2.0F;
    const omni_s2_real v6 = v2 - v5;
    const omni_s2_real v7 = (-2.0F) * nu;
    const omni_s2_real v8 = v7 * v5;
    const omni_s2_real v9 = expf(v8);
    const omni_s2_real v10 = log1pf(v9);
    const omni_s2_real v11 = v10 / nu;
    const omni_s2_real v12 = v6 - v11;
    const omni_s2_real v13 = rho_rate + alpha_rate;
    const omni_s2_real v14 = v13 + beta_rate;
    const omni_s2_real v15 = 0.5F * v14;
    const bool v16 = v3 < 0.0F;
    const omni_s2_real v17 = v16 ? (-1.0F) : 0.0F;
    const bool v18 = 0.0F < v3;
    const omni_s2_real v19 = v18 ? 1.0F : v17;
    const omni_s2_real v20 = v13 - beta_rate;
    const omni_s2_real v21 = v19 * v20;
    const omni_s2_real v22 = 0.5F * v21;
    const omni_s2_real v23 = v15 - v22;
    const omni_s2_real v24 = v7 * v22;
    const omni_s2_real v25 = v9 * v24;
    const omni_s2_real v26 = 1.0F + v9;
    const omni_s2_real v27 = v25 / v26;
    const omni_s2_real v28 = v27 / nu;
    const omni_s2_real v29 = v23 - v28;
    *gamma = v12;
    *gamma_rate = v29;
}

/* Normalized error e = (2 x - gamma_s) / gamma_d, from a = x - lower, b = upper - x. */
static inline omni_s2_real omni_s2_normalized_error(omni_s2_real a, omni_s2_real b, omni_s2_real width)
{
    const omni_s2_real v0 = a - b;
    const omni_s2_real v1 = v0 / width;
    return v1;
}

/* Transformed error epsilon = ln((1 + e)/(1 - e)) = ln(a/b) and xi = d epsilon/dx = 1/a + 1/b. */
static inline void omni_s2_transformed_error(omni_s2_real a, omni_s2_real b, omni_s2_real *epsilon,
                                             omni_s2_real *xi)
{
    const omni_s2_real v0 = b / a;
    const omni_s2_real v1 = logf(v0);
    const omni_s2_real v2 = -v1;
    const omni_s2_real v3 = 1.0F + v0;
    const omni_s2_real v4 = v3 / b;
    *epsilon = v2;
    *xi = v4;
}

/* Control law (13): u = -k xi epsilon. */
static inline omni_s2_real omni_s2_law(omni_s2_real k, omni_s2_real xi, omni_s2_real epsilon)
{
    const omni_s2_real v0 = k * xi;
    const omni_s2_real v1 = v0 * epsilon;
    const omni_s2_real v2 = -v1;
    return v2;
}

void omni_s2_alpha_init(omni_s2_real alpha[2 * OMNI_S2_N])
{
    for (int32_t i = 0; i < 4; ++i) {
        alpha[i] = 0.0F;
    }
}

void omni_s2_alpha_step(omni_s2_real t, omni_s2_real dt, omni_s2_real alpha[2 * OMNI_S2_N])
{
    const omni_s2_real t_zero = t * 0.0F;
    const omni_s2_real dt_zero = dt * 0.0F;
    const omni_s2_real both_zero = t_zero + dt_zero;
    omni_s2_real zero = both_zero;
    for (int32_t j = 0; j < 4; ++j) {
        const omni_s2_real alpha_j = alpha[j];
        const omni_s2_real alpha_zero = alpha_j * 0.0F;
        const omni_s2_real zeros = zero + alpha_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
    const bool bad = !finite;
    const bool forward = 0.0F < dt;
    const bool backward = !forward;
    const bool stay = bad || backward;
    if (stay) {
        return;
    }
    const bool short_step = dt < 1048576.0F;
    const omni_s2_real h = short_step ? dt : 1048576.0F;
    const omni_s2_real later = t + dt;
    const omni_s2_real held = omni_s2_hold(later, 9.0F);
    const omni_s2_real sigma = omni_s2_profile(held, 9.0F);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t reach_row = i * 4;
        const int32_t wall_row = i * 2;
        const omni_s2_real low_start = omni_s2_reach[reach_row];
        const int32_t low_end_at = reach_row + 1;
        const omni_s2_real low_end = omni_s2_reach[low_end_at];
        const omni_s2_real rho_low = omni_s2_reach_edge(low_start, low_end, sigma);
        const int32_t high_start_at = reach_row + 2;
        const omni_s2_real high_start = omni_s2_reach[high_start_at];
        const int32_t high_end_at = reach_row + 3;
        const omni_s2_real high_end = omni_s2_reach[high_end_at];
        const omni_s2_real rho_high = omni_s2_reach_edge(high_start, high_end, sigma);
        const omni_s2_real low_wall = omni_s2_walls[wall_row];
        const int32_t low_bumps_at = i * 8;
        omni_s2_real low_joined = 0.0F;
        for (int32_t low_j = 0; low_j < 1; ++low_j) {
            const int32_t low_offset = low_j * 4;
            const int32_t low_at = low_bumps_at + low_offset;
            const omni_s2_real low_height = omni_s2_bumps[low_at];
            const int32_t low_steepness_at = low_at + 1;
            const omni_s2_real low_steepness = omni_s2_bumps[low_steepness_at];
            const int32_t low_middle_at = low_at + 2;
            const omni_s2_real low_middle = omni_s2_bumps[low_middle_at];
            const int32_t low_radius_at = low_at + 3;
            const omni_s2_real low_radius = omni_s2_bumps[low_radius_at];
            const omni_s2_real low_bump = omni_s2_circumvent(held, low_height, low_steepness, low_middle, low_radius, 0.009615385F);
            low_joined = low_bump;
        }
        const omni_s2_real beta_low = low_wall + low_joined;
        const int32_t high_wall_at = wall_row + 1;
        const omni_s2_real high_wall = omni_s2_walls[high_wall_at];
        const int32_t high_bumps_at = i * 8;
        omni_s2_real high_joined = 0.0F;
        for (int32_t high_j = 0; high_j < 1; ++high_j) {
            const int32_t high_offset = high_j * 4;
            const int32_t high_at = high_bumps_at + high_offset;
            const int32_t high_height_at = high_at + 4;
            const omni_s2_real high_height = omni_s2_bumps[high_height_at];
            const int32_t high_steepness_at = high_at + 5;
            const omni_s2_real high_steepness = omni_s2_bumps[high_steepness_at];
            const int32_t high_middle_at = high_at + 6;
            const omni_s2_real high_middle = omni_s2_bumps[high_middle_at];
            const int32_t high_radius_at = high_at + 7;
            const omni_s2_real high_radius = omni_s2_bumps[high_radius_at];
            const omni_s2_real high_bump = omni_s2_circumvent(held, high_height, high_steepness, high_middle, high_radius, 0.009615385F);
            high_joined = high_bump;
        }
        const omni_s2_real beta_high = high_wall - high_joined;
        const omni_s2_real alpha_low_in = alpha[i];
        const bool alpha_low_positive = 0.0F < alpha_low_in;
        const omni_s2_real alpha_low_raised = alpha_low_positive ? alpha_low_in : 0.0F;
        const bool alpha_low_small = alpha_low_raised < 41.0F;
        const omni_s2_real alpha_low = alpha_low_small ? alpha_low_raised : 41.0F;
        const int32_t alpha_high_at = i + 2;
        const omni_s2_real alpha_high_in = alpha[alpha_high_at];
        const bool alpha_high_positive = 0.0F < alpha_high_in;
        const omni_s2_real alpha_high_raised = alpha_high_positive ? alpha_high_in : 0.0F;
        const bool alpha_high_small = alpha_high_raised < 41.0F;
        const omni_s2_real alpha_high = alpha_high_small ? alpha_high_raised : 41.0F;
        const omni_s2_real psi_low = beta_high - rho_low;
        const omni_s2_real psi_high = rho_high - beta_low;
        omni_s2_real low_p;
        omni_s2_real low_q;
        omni_s2_real low_theta_rest;
        omni_s2_real low_z_start;
        omni_s2_implicit_start(psi_low, alpha_low, h, 0.01F, 5.0F, 1.0F, 100.0F, &low_p, &low_q, &low_theta_rest, &low_z_start);
        omni_s2_real low_z = low_z_start;
        for (int32_t low_k = 0; low_k < 7; ++low_k) {
            const omni_s2_real low_z_next = omni_s2_newton(low_p, low_q, low_z);
            low_z = low_z_next;
        }
        const omni_s2_real alpha_low_out = omni_s2_implicit_end(low_q, low_theta_rest, low_z);
        alpha[i] = alpha_low_out;
        omni_s2_real high_p;
        omni_s2_real high_q;
        omni_s2_real high_theta_rest;
        omni_s2_real high_z_start;
        omni_s2_implicit_start(psi_high, alpha_high, h, 0.01F, 5.0F, 1.0F, 100.0F, &high_p, &high_q, &high_theta_rest, &high_z_start);
        omni_s2_real high_z = high_z_start;
        for (int32_t high_k = 0; high_k < 7; ++high_k) {
            const omni_s2_real high_z_next = omni_s2_newton(high_p, high_q, high_z);
            high_z = high_z_next;
        }
        const omni_s2_real alpha_high_out = omni_s2_implicit_end(high_q, high_theta_rest, high_z);
        const int32_t high_out_at = i + 2;
        alpha[high_out_at] = alpha_high_out;
    }
}

void omni_s2_alpha_rate(omni_s2_real t, const omni_s2_real alpha[2 * OMNI_S2_N],
                        omni_s2_real rate[2 * OMNI_S2_N], omni_s2_real jacobian[2 * OMNI_S2_N])
{
    const omni_s2_real t_zero = t * 0.0F;
    omni_s2_real zero = t_zero;
    for (int32_t j = 0; j < 4; ++j) {
        const omni_s2_real alpha_j = alpha[j];
        const omni_s2_real alpha_zero = alpha_j * 0.0F;
        const omni_s2_real zeros = zero + alpha_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 4; ++m) {
            rate[m] = (omni_s2_real)NAN;
            jacobian[m] = (omni_s2_real)NAN;
        }
        return;
    }
    const omni_s2_real held = omni_s2_hold(t, 9.0F);
    const omni_s2_real sigma = omni_s2_profile(held, 9.0F);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t reach_row = i * 4;
        const int32_t wall_row = i * 2;
        const omni_s2_real low_start = omni_s2_reach[reach_row];
        const int32_t low_end_at = reach_row + 1;
        const omni_s2_real low_end = omni_s2_reach[low_end_at];
        const omni_s2_real rho_low = omni_s2_reach_edge(low_start, low_end, sigma);
        const int32_t high_start_at = reach_row + 2;
        const omni_s2_real high_start = omni_s2_reach[high_start_at];
        const int32_t high_end_at = reach_row + 3;
        const omni_s2_real high_end = omni_s2_reach[high_end_at];
        const omni_s2_real rho_high = omni_s2_reach_edge(high_start, high_end, sigma);
        const omni_s2_real low_wall = omni_s2_walls[wall_row];
        const int32_t low_bumps_at = i * 8;
        omni_s2_real low_joined = 0.0F;
        for (int32_t low_j = 0; low_j < 1; ++low_j) {
            const int32_t low_offset = low_j * 4;
            const int32_t low_at = low_bumps_at + low_offset;
            const omni_s2_real low_height = omni_s2_bumps[low_at];
            const int32_t low_steepness_at = low_at + 1;
            const omni_s2_real low_steepness = omni_s2_bumps[low_steepness_at];
            const int32_t low_middle_at = low_at + 2;
            const omni_s2_real low_middle = omni_s2_bumps[low_middle_at];
            const int32_t low_radius_at = low_at + 3;
            const omni_s2_real low_radius = omni_s2_bumps[low_radius_at];
            const omni_s2_real low_bump = omni_s2_circumvent(held, low_height, low_steepness, low_middle, low_radius, 0.009615385F);
            low_joined = low_bump;
        }
        const omni_s2_real beta_low = low_wall + low_joined;
        const int32_t high_wall_at = wall_row + 1;
        const omni_s2_real high_wall = omni_s2_walls[high_wall_at];
        const int32_t high_bumps_at = i * 8;
        omni_s2_real high_joined = 0.0F;
        for (int32_t high_j = 0; high_j < 1; ++high_j) {
            const int32_t high_offset = high_j * 4;
            const int32_t high_at = high_bumps_at + high_offset;
            const int32_t high_height_at = high_at + 4;
            const omni_s2_real high_height = omni_s2_bumps[high_height_at];
            const int32_t high_steepness_at = high_at + 5;
            const omni_s2_real high_steepness = omni_s2_bumps[high_steepness_at];
            const int32_t high_middle_at = high_at + 6;
            const omni_s2_real high_middle = omni_s2_bumps[high_middle_at];
            const int32_t high_radius_at = high_at + 7;
            const omni_s2_real high_radius = omni_s2_bumps[high_radius_at];
            const omni_s2_real high_bump = omni_s2_circumvent(held, high_height, high_steepness, high_middle, high_radius, 0.009615385F);
            high_joined = high_bump;
        }
        const omni_s2_real beta_high = high_wall - high_joined;
        const omni_s2_real alpha_low_in = alpha[i];
        const bool alpha_low_positive = 0.0F < alpha_low_in;
        const omni_s2_real alpha_low_raised = alpha_low_positive ? alpha_low_in : 0.0F;
        const bool alpha_low_small = alpha_low_raised < 41.0F;
        const omni_s2_real alpha_low = alpha_low_small ? alpha_low_raised : 41.0F;
        const int32_t alpha_high_at = i + 2;
        const omni_s2_real alpha_high_in = alpha[alpha_high_at];
        const bool alpha_high_positive = 0.0F < alpha_high_in;
        const omni_s2_real alpha_high_raised = alpha_high_positive ? alpha_high_in : 0.0F;
        const bool alpha_high_small = alpha_high_raised < 41.0F;
        const omni_s2_real alpha_high = alpha_high_small ? alpha_high_raised : 41.0F;
        const omni_s2_real psi_low = beta_high - rho_low;
        const omni_s2_real psi_high = rho_high - beta_low;
        omni_s2_real rate_low;
        omni_s2_real jacobian_low;
        omni_s2_update_rate(psi_low, alpha_low, 0.01F, 5.0F, 1.0F, 100.0F, &rate_low, &jacobian_low);
        rate[i] = rate_low;
        jacobian[i] = jacobian_low;
        omni_s2_real rate_high;
        omni_s2_real jacobian_high;
        omni_s2_update_rate(psi_high, alpha_high, 0.01F, 5.0F, 1.0F, 100.0F, &rate_high, &jacobian_high);
        const int32_t high_out_at = i + 2;
        rate[high_out_at] = rate_high;
        jacobian[high_out_at] = jacobian_high;
    }
}

void omni_s2_tube(omni_s2_real t, const omni_s2_real alpha[2 * OMNI_S2_N], omni_s2_real lower[OMNI_S2_N],
                  omni_s2_real upper[OMNI_S2_N])
{
    const omni_s2_real t_zero = t * 0.0F;
    omni_s2_real zero = t_zero;
    for (int32_t j = 0; j < 4; ++j) {
        const omni_s2_real alpha_j = alpha[j];
        const omni_s2_real alpha_zero = alpha_j * 0.0F;
        const omni_s2_real zeros = zero + alpha_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 2; ++m) {
            lower[m] = (omni_s2_real)NAN;
            upper[m] = (omni_s2_real)NAN;
        }
        return;
    }
    const omni_s2_real held = omni_s2_hold(t, 9.0F);
    const omni_s2_real sigma = omni_s2_profile(held, 9.0F);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t reach_row = i * 4;
        const int32_t wall_row = i * 2;
        const omni_s2_real low_start = omni_s2_reach[reach_row];
        const int32_t low_end_at = reach_row + 1;
        const omni_s2_real low_end = omni_s2_reach[low_end_at];
        const omni_s2_real rho_low = omni_s2_reach_edge(low_start, low_end, sigma);
        const int32_t high_start_at = reach_row + 2;
        const omni_s2_real high_start = omni_s2_reach[high_start_at];
        const int32_t high_end_at = reach_row + 3;
        const omni_s2_real high_end = omni_s2_reach[high_end_at];
        const omni_s2_real rho_high = omni_s2_reach_edge(high_start, high_end, sigma);
        const omni_s2_real low_wall = omni_s2_walls[wall_row];
        const int32_t low_bumps_at = i * 8;
        omni_s2_real low_joined = 0.0F;
        for (int32_t low_j = 0; low_j < 1; ++low_j) {
            const int32_t low_offset = low_j * 4;
            const int32_t low_at = low_bumps_at + low_offset;
            const omni_s2_real low_height = omni_s2_bumps[low_at];
            const int32_t low_steepness_at = low_at + 1;
            const omni_s2_real low_steepness = omni_s2_bumps[low_steepness_at];
            const int32_t low_middle_at = low_at + 2;
            const omni_s2_real low_middle = omni_s2_bumps[low_middle_at];
            const int32_t low_radius_at = low_at + 3;
            const omni_s2_real low_radius = omni_s2_bumps[low_radius_at];
            const omni_s2_real low_bump = omni_s2_circumvent(held, low_height, low_steepness, low_middle, low_radius, 0.009615385F);
            low_joined = low_bump;
        }
        const omni_s2_real beta_low = low_wall + low_joined;
        const int32_t high_wall_at = wall_row + 1;
        const omni_s2_real high_wall = omni_s2_walls[high_wall_at];
        const int32_t high_bumps_at = i * 8;
        omni_s2_real high_joined = 0.0F;
        for (int32_t high_j = 0; high_j < 1; ++high_j) {
            const int32_t high_offset = high_j * 4;
            const int32_t high_at = high_bumps_at + high_offset;
            const int32_t high_height_at = high_at + 4;
            const omni_s2_real high_height = omni_s2_bumps[high_height_at];
            const int32_t high_steepness_at = high_at + 5;
            const omni_s2_real high_steepness = omni_s2_bumps[high_steepness_at];
            const int32_t high_middle_at = high_at + 6;
            const omni_s2_real high_middle = omni_s2_bumps[high_middle_at];
            const int32_t high_radius_at = high_at + 7;
            const omni_s2_real high_radius = omni_s2_bumps[high_radius_at];
            const omni_s2_real high_bump = omni_s2_circumvent(held, high_height, high_steepness, high_middle, high_radius, 0.009615385F);
            high_joined = high_bump;
        }
        const omni_s2_real beta_high = high_wall - high_joined;
        const omni_s2_real alpha_low_in = alpha[i];
        const bool alpha_low_positive = 0.0F < alpha_low_in;
        const omni_s2_real alpha_low_raised = alpha_low_positive ? alpha_low_in : 0.0F;
        const bool alpha_low_small = alpha_low_raised < 41.0F;
        const omni_s2_real alpha_low = alpha_low_small ? alpha_low_raised : 41.0F;
        const int32_t alpha_high_at = i + 2;
        const omni_s2_real alpha_high_in = alpha[alpha_high_at];
        const bool alpha_high_positive = 0.0F < alpha_high_in;
        const omni_s2_real alpha_high_raised = alpha_high_positive ? alpha_high_in : 0.0F;
        const bool alpha_high_small = alpha_high_raised < 41.0F;
        const omni_s2_real alpha_high = alpha_high_small ? alpha_high_raised : 41.0F;
        const omni_s2_real gamma_low = omni_s2_lower_edge(rho_low, alpha_low, beta_low, 100.0F);
        const omni_s2_real gamma_high = omni_s2_upper_edge(rho_high, alpha_high, beta_high, 100.0F);
        lower[i] = gamma_low;
        upper[i] = gamma_high;
    }
}

void omni_s2_tube_rate(omni_s2_real t, const omni_s2_real alpha[2 * OMNI_S2_N],
                       omni_s2_real lower_rate[OMNI_S2_N], omni_s2_real upper_rate[OMNI_S2_N])
{
    const omni_s2_real t_zero = t * 0.0F;
    omni_s2_real zero = t_zero;
    for (int32_t j = 0; j < 4; ++j) {
        const omni_s2_real alpha_j = alpha[j];
        const omni_s2_real alpha_zero = alpha_j * 0.0F;
        const omni_s2_real zeros = zero + alpha_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 2; ++m) {
            lower_rate[m] = (omni_s2_real)NAN;
            upper_rate[m] = (omni_s2_real)NAN;
        }
        return;
    }
    const omni_s2_real held = omni_s2_hold(t, 9.0F);
    omni_s2_real sigma;
    omni_s2_real sigma_rate;
    omni_s2_profile_rate(held, 9.0F, &sigma, &sigma_rate);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t reach_row = i * 4;
        const int32_t wall_row = i * 2;
        const omni_s2_real low_start = omni_s2_reach[reach_row];
        const int32_t low_end_at = reach_row + 1;
        const omni_s2_real low_end = omni_s2_reach[low_end_at];
        const omni_s2_real rho_low = omni_s2_reach_edge(low_start, low_end, sigma);
        const omni_s2_real rho_low_rate = omni_s2_reach_rate(low_start, low_end, sigma_rate);
        const int32_t high_start_at = reach_row + 2;
        const omni_s2_real high_start = omni_s2_reach[high_start_at];
        const int32_t high_end_at = reach_row + 3;
        const omni_s2_real high_end = omni_s2_reach[high_end_at];
        const omni_s2_real rho_high = omni_s2_reach_edge(high_start, high_end, sigma);
        const omni_s2_real rho_high_rate = omni_s2_reach_rate(high_start, high_end, sigma_rate);
        const omni_s2_real low_wall = omni_s2_walls[wall_row];
        const int32_t low_bumps_at = i * 8;
        omni_s2_real low_joined = 0.0F;
        omni_s2_real low_joined_rate = 0.0F;
        for (int32_t low_j = 0; low_j < 1; ++low_j) {
            const int32_t low_offset = low_j * 4;
            const int32_t low_at = low_bumps_at + low_offset;
            const omni_s2_real low_height = omni_s2_bumps[low_at];
            const int32_t low_steepness_at = low_at + 1;
            const omni_s2_real low_steepness = omni_s2_bumps[low_steepness_at];
            const int32_t low_middle_at = low_at + 2;
            const omni_s2_real low_middle = omni_s2_bumps[low_middle_at];
            const int32_t low_radius_at = low_at + 3;
            const omni_s2_real low_radius = omni_s2_bumps[low_radius_at];
            omni_s2_real low_bump;
            omni_s2_real low_bump_rate;
            omni_s2_circumvent_rate(held, low_height, low_steepness, low_middle, low_radius, 0.009615385F, &low_bump, &low_bump_rate);
            low_joined = low_bump;
            low_joined_rate = low_bump_rate;
        }
        const omni_s2_real beta_low = low_wall + low_joined;
        const int32_t high_wall_at = wall_row + 1;
        const omni_s2_real high_wall = omni_s2_walls[high_wall_at];
        const int32_t high_bumps_at = i * 8;
        omni_s2_real high_joined = 0.0F;
        omni_s2_real high_joined_rate = 0.0F;
        for (int32_t high_j = 0; high_j < 1; ++high_j) {
            const int32_t high_offset = high_j * 4;
            const int32_t high_at = high_bumps_at + high_offset;
            const int32_t high_height_at = high_at + 4;
            const omni_s2_real high_height = omni_s2_bumps[high_height_at];
            const int32_t high_steepness_at = high_at + 5;
            const omni_s2_real high_steepness = omni_s2_bumps[high_steepness_at];
            const int32_t high_middle_at = high_at + 6;
            const omni_s2_real high_middle = omni_s2_bumps[high_middle_at];
            const int32_t high_radius_at = high_at + 7;
            const omni_s2_real high_radius = omni_s2_bumps[high_radius_at];
            omni_s2_real high_bump;
            omni_s2_real high_bump_rate;
            omni_s2_circumvent_rate(held, high_height, high_steepness, high_middle, high_radius, 0.009615385F, &high_bump, &high_bump_rate);
            high_joined = high_bump;
            high_joined_rate = high_bump_rate;
        }
        const omni_s2_real beta_high = high_wall - high_joined;
        const omni_s2_real beta_high_rate = -high_joined_rate;
        const omni_s2_real alpha_low_in = alpha[i];
        const bool alpha_low_positive = 0.0F < alpha_low_in;
        const omni_s2_real alpha_low_raised = alpha_low_positive ? alpha_low_in : 0.0F;
        const bool alpha_low_small = alpha_low_raised < 41.0F;
        const omni_s2_real alpha_low = alpha_low_small ? alpha_low_raised : 41.0F;
        const int32_t alpha_high_at = i + 2;
        const omni_s2_real alpha_high_in = alpha[alpha_high_at];
        const bool alpha_high_positive = 0.0F < alpha_high_in;
        const omni_s2_real alpha_high_raised = alpha_high_positive ? alpha_high_in : 0.0F;
        const bool alpha_high_small = alpha_high_raised < 41.0F;
        const omni_s2_real alpha_high = alpha_high_small ? alpha_high_raised : 41.0F;
        const omni_s2_real psi_low = beta_high - rho_low;
        const omni_s2_real psi_high = rho_high - beta_low;
        omni_s2_real alpha_low_rate;
        omni_s2_real jacobian_low;
        omni_s2_update_rate(psi_low, alpha_low, 0.01F, 5.0F, 1.0F, 100.0F, &alpha_low_rate, &jacobian_low);
        omni_s2_real gamma_low;
        omni_s2_real gamma_low_rate;
        omni_s2_lower_edge_rate(rho_low, alpha_low, beta_low, 100.0F, rho_low_rate, alpha_low_rate, low_joined_rate, &gamma_low, &gamma_low_rate);
        lower_rate[i] = gamma_low_rate;
        omni_s2_real alpha_high_rate;
        omni_s2_real jacobian_high;
        omni_s2_update_rate(psi_high, alpha_high, 0.01F, 5.0F, 1.0F, 100.0F, &alpha_high_rate, &jacobian_high);
        omni_s2_real gamma_high;
        omni_s2_real gamma_high_rate;
        omni_s2_upper_edge_rate(rho_high, alpha_high, beta_high, 100.0F, rho_high_rate, alpha_high_rate, beta_high_rate, &gamma_high, &gamma_high_rate);
        upper_rate[i] = gamma_high_rate;
    }
}

omni_s2_status omni_s2_control(omni_s2_real t, const omni_s2_real alpha[2 * OMNI_S2_N],
                               const omni_s2_real x[OMNI_S2_N], omni_s2_real u[OMNI_S2_N])
{
    const omni_s2_real t_zero = t * 0.0F;
    omni_s2_real zero = t_zero;
    for (int32_t j = 0; j < 4; ++j) {
        const omni_s2_real alpha_j = alpha[j];
        const omni_s2_real alpha_zero = alpha_j * 0.0F;
        const omni_s2_real zeros = zero + alpha_zero;
        zero = zeros;
    }
    omni_s2_real x_zeros = zero;
    for (int32_t k = 0; k < 2; ++k) {
        const omni_s2_real x_k = x[k];
        const omni_s2_real x_zero = x_k * 0.0F;
        const omni_s2_real x_sum = x_zeros + x_zero;
        x_zeros = x_sum;
    }
    const bool finite = x_zeros <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 2; ++m) {
            u[m] = 0.0F;
        }
        return OMNI_S2_BAD_INPUT;
    }
    const omni_s2_real held = omni_s2_hold(t, 9.0F);
    const omni_s2_real sigma = omni_s2_profile(held, 9.0F);
    bool outside = false;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t reach_row = i * 4;
        const int32_t wall_row = i * 2;
        const omni_s2_real low_start = omni_s2_reach[reach_row];
        const int32_t low_end_at = reach_row + 1;
        const omni_s2_real low_end = omni_s2_reach[low_end_at];
        const omni_s2_real rho_low = omni_s2_reach_edge(low_start, low_end, sigma);
        const int32_t high_start_at = reach_row + 2;
        const omni_s2_real high_start = omni_s2_reach[high_start_at];
        const int32_t high_end_at = reach_row + 3;
        const omni_s2_real high_end = omni_s2_reach[high_end_at];
        const omni_s2_real rho_high = omni_s2_reach_edge(high_start, high_end, sigma);
        const omni_s2_real low_wall = omni_s2_walls[wall_row];
        const int32_t low_bumps_at = i * 8;
        omni_s2_real low_joined = 0.0F;
        for (int32_t low_j = 0; low_j < 1; ++low_j) {
            const int32_t low_offset = low_j * 4;
            const int32_t low_at = low_bumps_at + low_offset;
            const omni_s2_real low_height = omni_s2_bumps[low_at];
            const int32_t low_steepness_at = low_at + 1;
            const omni_s2_real low_steepness = omni_s2_bumps[low_steepness_at];
            const int32_t low_middle_at = low_at + 2;
            const omni_s2_real low_middle = omni_s2_bumps[low_middle_at];
            const int32_t low_radius_at = low_at + 3;
            const omni_s2_real low_radius = omni_s2_bumps[low_radius_at];
            const omni_s2_real low_bump = omni_s2_circumvent(held, low_height, low_steepness, low_middle, low_radius, 0.009615385F);
            low_joined = low_bump;
        }
        const omni_s2_real beta_low = low_wall + low_joined;
        const int32_t high_wall_at = wall_row + 1;
        const omni_s2_real high_wall = omni_s2_walls[high_wall_at];
        const int32_t high_bumps_at = i * 8;
        omni_s2_real high_joined = 0.0F;
        for (int32_t high_j = 0; high_j < 1; ++high_j) {
            const int32_t high_offset = high_j * 4;
            const int32_t high_at = high_bumps_at + high_offset;
            const int32_t high_height_at = high_at + 4;
            const omni_s2_real high_height = omni_s2_bumps[high_height_at];
            const int32_t high_steepness_at = high_at + 5;
            const omni_s2_real high_steepness = omni_s2_bumps[high_steepness_at];
            const int32_t high_middle_at = high_at + 6;
            const omni_s2_real high_middle = omni_s2_bumps[high_middle_at];
            const int32_t high_radius_at = high_at + 7;
            const omni_s2_real high_radius = omni_s2_bumps[high_radius_at];
            const omni_s2_real high_bump = omni_s2_circumvent(held, high_height, high_steepness, high_middle, high_radius, 0.009615385F);
            high_joined = high_bump;
        }
        const omni_s2_real beta_high = high_wall - high_joined;
        const omni_s2_real alpha_low_in = alpha[i];
        const bool alpha_low_positive = 0.0F < alpha_low_in;
        const omni_s2_real alpha_low_raised = alpha_low_positive ? alpha_low_in : 0.0F;
        const bool alpha_low_small = alpha_low_raised < 41.0F;
        const omni_s2_real alpha_low = alpha_low_small ? alpha_low_raised : 41.0F;
        const int32_t alpha_high_at = i + 2;
        const omni_s2_real alpha_high_in = alpha[alpha_high_at];
        const bool alpha_high_positive = 0.0F < alpha_high_in;
        const omni_s2_real alpha_high_raised = alpha_high_positive ? alpha_high_in : 0.0F;
        const bool alpha_high_small = alpha_high_raised < 41.0F;
        const omni_s2_real alpha_high = alpha_high_small ? alpha_high_raised : 41.0F;
        const omni_s2_real gamma_low = omni_s2_lower_edge(rho_low, alpha_low, beta_low, 100.0F);
        const omni_s2_real gamma_high = omni_s2_upper_edge(rho_high, alpha_high, beta_high, 100.0F);
        const omni_s2_real x_i = x[i];
        const omni_s2_real width = gamma_high - gamma_low;
        const bool filled = 0.0F < width;
        const bool empty = !filled;
        const bool wide = 9.536743e-7F < width;
        const omni_s2_real safe_width = wide ? width : 9.536743e-7F;
        const omni_s2_real to_lower = x_i - gamma_low;
        const omni_s2_real to_upper = gamma_high - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const omni_s2_real distance = upper_nearer ? to_upper : to_lower;
        const omni_s2_real gain = upper_nearer ? (-0.5F) : 0.5F;
        const omni_s2_real smallest = safe_width * 0.005F;
        const omni_s2_real widened = safe_width - width;
        const omni_s2_real half = widened * 0.5F;
        const omni_s2_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const omni_s2_real to_nearer = clear ? safe_distance : smallest;
        const omni_s2_real to_farther = safe_width - to_nearer;
        const bool inside = 0.0F < distance;
        const bool outside_next = inside ? outside : true;
        omni_s2_real epsilon;
        omni_s2_real xi;
        omni_s2_transformed_error(to_nearer, to_farther, &epsilon, &xi);
        const omni_s2_real u_i = omni_s2_law(gain, xi, epsilon);
        const omni_s2_real u_or_zero = empty ? 0.0F : u_i;
        u[i] = u_or_zero;
        outside = outside_next;
    }
    return outside ? OMNI_S2_OUTSIDE_TUBE : OMNI_S2_OK;
}

omni_s2_real omni_s2_margin(omni_s2_real t, const omni_s2_real alpha[2 * OMNI_S2_N],
                            const omni_s2_real x[OMNI_S2_N])
{
    const omni_s2_real t_zero = t * 0.0F;
    omni_s2_real zero = t_zero;
    for (int32_t j = 0; j < 4; ++j) {
        const omni_s2_real alpha_j = alpha[j];
        const omni_s2_real alpha_zero = alpha_j * 0.0F;
        const omni_s2_real zeros = zero + alpha_zero;
        zero = zeros;
    }
    omni_s2_real x_zeros = zero;
    for (int32_t k = 0; k < 2; ++k) {
        const omni_s2_real x_k = x[k];
        const omni_s2_real x_zero = x_k * 0.0F;
        const omni_s2_real x_sum = x_zeros + x_zero;
        x_zeros = x_sum;
    }
    const bool finite = x_zeros <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        return (omni_s2_real)NAN;
    }
    const omni_s2_real held = omni_s2_hold(t, 9.0F);
    const omni_s2_real sigma = omni_s2_profile(held, 9.0F);
    omni_s2_real margin = 0.5F;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t reach_row = i * 4;
        const int32_t wall_row = i * 2;
        const omni_s2_real low_start = omni_s2_reach[reach_row];
        const int32_t low_end_at = reach_row + 1;
        const omni_s2_real low_end = omni_s2_reach[low_end_at];
        const omni_s2_real rho_low = omni_s2_reach_edge(low_start, low_end, sigma);
        const int32_t high_start_at = reach_row + 2;
        const omni_s2_real high_start = omni_s2_reach[high_start_at];
        const int32_t high_end_at = reach_row + 3;
        const omni_s2_real high_end = omni_s2_reach[high_end_at];
        const omni_s2_real rho_high = omni_s2_reach_edge(high_start, high_end, sigma);
        const omni_s2_real low_wall = omni_s2_walls[wall_row];
        const int32_t low_bumps_at = i * 8;
        omni_s2_real low_joined = 0.0F;
        for (int32_t low_j = 0; low_j < 1; ++low_j) {
            const int32_t low_offset = low_j * 4;
            const int32_t low_at = low_bumps_at + low_offset;
            const omni_s2_real low_height = omni_s2_bumps[low_at];
            const int32_t low_steepness_at = low_at + 1;
            const omni_s2_real low_steepness = omni_s2_bumps[low_steepness_at];
            const int32_t low_middle_at = low_at + 2;
            const omni_s2_real low_middle = omni_s2_bumps[low_middle_at];
            const int32_t low_radius_at = low_at + 3;
            const omni_s2_real low_radius = omni_s2_bumps[low_radius_at];
            const omni_s2_real low_bump = omni_s2_circumvent(held, low_height, low_steepness, low_middle, low_radius, 0.009615385F);
            low_joined = low_bump;
        }
        const omni_s2_real beta_low = low_wall + low_joined;
        const int32_t high_wall_at = wall_row + 1;
        const omni_s2_real high_wall = omni_s2_walls[high_wall_at];
        const int32_t high_bumps_at = i * 8;
        omni_s2_real high_joined = 0.0F;
        for (int32_t high_j = 0; high_j < 1; ++high_j) {
            const int32_t high_offset = high_j * 4;
            const int32_t high_at = high_bumps_at + high_offset;
            const int32_t high_height_at = high_at + 4;
            const omni_s2_real high_height = omni_s2_bumps[high_height_at];
            const int32_t high_steepness_at = high_at + 5;
            const omni_s2_real high_steepness = omni_s2_bumps[high_steepness_at];
            const int32_t high_middle_at = high_at + 6;
            const omni_s2_real high_middle = omni_s2_bumps[high_middle_at];
            const int32_t high_radius_at = high_at + 7;
            const omni_s2_real high_radius = omni_s2_bumps[high_radius_at];
            const omni_s2_real high_bump = omni_s2_circumvent(held, high_height, high_steepness, high_middle, high_radius, 0.009615385F);
            high_joined = high_bump;
        }
        const omni_s2_real beta_high = high_wall - high_joined;
        const omni_s2_real alpha_low_in = alpha[i];
        const bool alpha_low_positive = 0.0F < alpha_low_in;
        const omni_s2_real alpha_low_raised = alpha_low_positive ? alpha_low_in : 0.0F;
        const bool alpha_low_small = alpha_low_raised < 41.0F;
        const omni_s2_real alpha_low = alpha_low_small ? alpha_low_raised : 41.0F;
        const int32_t alpha_high_at = i + 2;
        const omni_s2_real alpha_high_in = alpha[alpha_high_at];
        const bool alpha_high_positive = 0.0F < alpha_high_in;
        const omni_s2_real alpha_high_raised = alpha_high_positive ? alpha_high_in : 0.0F;
        const bool alpha_high_small = alpha_high_raised < 41.0F;
        const omni_s2_real alpha_high = alpha_high_small ? alpha_high_raised : 41.0F;
        const omni_s2_real gamma_low = omni_s2_lower_edge(rho_low, alpha_low, beta_low, 100.0F);
        const omni_s2_real gamma_high = omni_s2_upper_edge(rho_high, alpha_high, beta_high, 100.0F);
        const omni_s2_real x_i = x[i];
        const omni_s2_real width = gamma_high - gamma_low;
        const bool wide = 9.536743e-7F < width;
        const omni_s2_real safe_width = wide ? width : 9.536743e-7F;
        const omni_s2_real to_lower = x_i - gamma_low;
        const omni_s2_real to_upper = gamma_high - x_i;
        const bool x_nearer = to_upper < to_lower;
        const omni_s2_real x_distance = x_nearer ? to_upper : to_lower;
        const omni_s2_real x_share = x_distance / safe_width;
        const bool x_beyond = x_share < (-1.0F);
        const omni_s2_real margin_x = x_beyond ? (-1.0F) : x_share;
        const bool less = margin_x < margin;
        const omni_s2_real margin_next = less ? margin_x : margin;
        margin = margin_next;
    }
    return margin;
}

void omni_s2_margins(omni_s2_real t, const omni_s2_real alpha[2 * OMNI_S2_N], const omni_s2_real x[OMNI_S2_N],
                     omni_s2_real margin[OMNI_S2_N])
{
    const omni_s2_real t_zero = t * 0.0F;
    omni_s2_real zero = t_zero;
    for (int32_t j = 0; j < 4; ++j) {
        const omni_s2_real alpha_j = alpha[j];
        const omni_s2_real alpha_zero = alpha_j * 0.0F;
        const omni_s2_real zeros = zero + alpha_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 2; ++m) {
            margin[m] = (omni_s2_real)NAN;
        }
        return;
    }
    const omni_s2_real held = omni_s2_hold(t, 9.0F);
    const omni_s2_real sigma = omni_s2_profile(held, 9.0F);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t reach_row = i * 4;
        const int32_t wall_row = i * 2;
        const omni_s2_real low_start = omni_s2_reach[reach_row];
        const int32_t low_end_at = reach_row + 1;
        const omni_s2_real low_end = omni_s2_reach[low_end_at];
        const omni_s2_real rho_low = omni_s2_reach_edge(low_start, low_end, sigma);
        const int32_t high_start_at = reach_row + 2;
        const omni_s2_real high_start = omni_s2_reach[high_start_at];
        const int32_t high_end_at = reach_row + 3;
        const omni_s2_real high_end = omni_s2_reach[high_end_at];
        const omni_s2_real rho_high = omni_s2_reach_edge(high_start, high_end, sigma);
        const omni_s2_real low_wall = omni_s2_walls[wall_row];
        const int32_t low_bumps_at = i * 8;
        omni_s2_real low_joined = 0.0F;
        for (int32_t low_j = 0; low_j < 1; ++low_j) {
            const int32_t low_offset = low_j * 4;
            const int32_t low_at = low_bumps_at + low_offset;
            const omni_s2_real low_height = omni_s2_bumps[low_at];
            const int32_t low_steepness_at = low_at + 1;
            const omni_s2_real low_steepness = omni_s2_bumps[low_steepness_at];
            const int32_t low_middle_at = low_at + 2;
            const omni_s2_real low_middle = omni_s2_bumps[low_middle_at];
            const int32_t low_radius_at = low_at + 3;
            const omni_s2_real low_radius = omni_s2_bumps[low_radius_at];
            const omni_s2_real low_bump = omni_s2_circumvent(held, low_height, low_steepness, low_middle, low_radius, 0.009615385F);
            low_joined = low_bump;
        }
        const omni_s2_real beta_low = low_wall + low_joined;
        const int32_t high_wall_at = wall_row + 1;
        const omni_s2_real high_wall = omni_s2_walls[high_wall_at];
        const int32_t high_bumps_at = i * 8;
        omni_s2_real high_joined = 0.0F;
        for (int32_t high_j = 0; high_j < 1; ++high_j) {
            const int32_t high_offset = high_j * 4;
            const int32_t high_at = high_bumps_at + high_offset;
            const int32_t high_height_at = high_at + 4;
            const omni_s2_real high_height = omni_s2_bumps[high_height_at];
            const int32_t high_steepness_at = high_at + 5;
            const omni_s2_real high_steepness = omni_s2_bumps[high_steepness_at];
            const int32_t high_middle_at = high_at + 6;
            const omni_s2_real high_middle = omni_s2_bumps[high_middle_at];
            const int32_t high_radius_at = high_at + 7;
            const omni_s2_real high_radius = omni_s2_bumps[high_radius_at];
            const omni_s2_real high_bump = omni_s2_circumvent(held, high_height, high_steepness, high_middle, high_radius, 0.009615385F);
            high_joined = high_bump;
        }
        const omni_s2_real beta_high = high_wall - high_joined;
        const omni_s2_real alpha_low_in = alpha[i];
        const bool alpha_low_positive = 0.0F < alpha_low_in;
        const omni_s2_real alpha_low_raised = alpha_low_positive ? alpha_low_in : 0.0F;
        const bool alpha_low_small = alpha_low_raised < 41.0F;
        const omni_s2_real alpha_low = alpha_low_small ? alpha_low_raised : 41.0F;
        const int32_t alpha_high_at = i + 2;
        const omni_s2_real alpha_high_in = alpha[alpha_high_at];
        const bool alpha_high_positive = 0.0F < alpha_high_in;
        const omni_s2_real alpha_high_raised = alpha_high_positive ? alpha_high_in : 0.0F;
        const bool alpha_high_small = alpha_high_raised < 41.0F;
        const omni_s2_real alpha_high = alpha_high_small ? alpha_high_raised : 41.0F;
        const omni_s2_real gamma_low = omni_s2_lower_edge(rho_low, alpha_low, beta_low, 100.0F);
        const omni_s2_real gamma_high = omni_s2_upper_edge(rho_high, alpha_high, beta_high, 100.0F);
        const omni_s2_real x_i = x[i];
        const omni_s2_real width = gamma_high - gamma_low;
        const bool wide = 9.536743e-7F < width;
        const omni_s2_real safe_width = wide ? width : 9.536743e-7F;
        const omni_s2_real to_lower = x_i - gamma_low;
        const omni_s2_real to_upper = gamma_high - x_i;
        const bool x_nearer = to_upper < to_lower;
        const omni_s2_real x_distance = x_nearer ? to_upper : to_lower;
        const omni_s2_real x_share = x_distance / safe_width;
        const bool x_beyond = x_share < (-1.0F);
        const omni_s2_real margin_x = x_beyond ? (-1.0F) : x_share;
        margin[i] = margin_x;
    }
}

void omni_s2_transform(const omni_s2_real lower[OMNI_S2_N], const omni_s2_real upper[OMNI_S2_N],
                       const omni_s2_real x[OMNI_S2_N], omni_s2_real e[OMNI_S2_N],
                       omni_s2_real epsilon[OMNI_S2_N], omni_s2_real xi[OMNI_S2_N])
{
    for (int32_t i = 0; i < 2; ++i) {
        const omni_s2_real lower_edge = lower[i];
        const omni_s2_real upper_edge = upper[i];
        const omni_s2_real x_i = x[i];
        const omni_s2_real width = upper_edge - lower_edge;
        const bool filled = 0.0F < width;
        const bool empty = !filled;
        const bool wide = 9.536743e-7F < width;
        const omni_s2_real safe_width = wide ? width : 9.536743e-7F;
        const omni_s2_real to_lower = x_i - lower_edge;
        const omni_s2_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const omni_s2_real distance = upper_nearer ? to_upper : to_lower;
        const omni_s2_real sign = upper_nearer ? (-1.0F) : 1.0F;
        const omni_s2_real smallest = safe_width * 0.005F;
        const omni_s2_real widened = safe_width - width;
        const omni_s2_real half = widened * 0.5F;
        const omni_s2_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const omni_s2_real to_nearer = clear ? safe_distance : smallest;
        const omni_s2_real to_farther = safe_width - to_nearer;
        const omni_s2_real a = upper_nearer ? to_farther : to_nearer;
        const omni_s2_real b = upper_nearer ? to_nearer : to_farther;
        const omni_s2_real e_i = omni_s2_normalized_error(a, b, safe_width);
        const bool e_above = (-0.99F) < e_i;
        const omni_s2_real e_raised = e_above ? e_i : (-0.99F);
        const bool e_beyond = 0.99F < e_raised;
        const omni_s2_real e_limited = e_beyond ? 0.99F : e_raised;
        omni_s2_real epsilon_nearer;
        omni_s2_real xi_i;
        omni_s2_transformed_error(to_nearer, to_farther, &epsilon_nearer, &xi_i);
        const omni_s2_real epsilon_i = sign * epsilon_nearer;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_width = isfinite(width) != 0;
        const bool finite = finite_x && finite_width;
        const omni_s2_real e_or_zero = empty ? 0.0F : e_limited;
        const omni_s2_real e_out = finite ? e_or_zero : (omni_s2_real)NAN;
        e[i] = e_out;
        const omni_s2_real epsilon_or_zero = empty ? 0.0F : epsilon_i;
        const omni_s2_real epsilon_out = finite ? epsilon_or_zero : (omni_s2_real)NAN;
        epsilon[i] = epsilon_out;
        const omni_s2_real xi_or_zero = empty ? 0.0F : xi_i;
        const omni_s2_real xi_out = finite ? xi_or_zero : (omni_s2_real)NAN;
        xi[i] = xi_out;
    }
}
