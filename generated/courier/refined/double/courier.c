/* courier.c: prescribed-time reach-avoid-stay controller, refined tube, double precision.
 *
 * Certified (courier.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 * Every x(t) that stays in the tube satisfies the mission (P10): (eventually[4, 9] (always[0, 2] dock and
 * eventually[2, 12] (left or right)) and (not lab until[0, 24] dock) and always[0, 12] (not dock or eventually[0, 8]
 * charger)); times are seconds of t. It still holds where every time at which the tube is in a region, or off one, is
 * wrong by up to 0.00585 s.
 *
 * One statement a line, every value assigned once. Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
 */
#include "courier.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* Flags that change results are refused, before the pragma: after it avr-gcc has no macros for them. */
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "courier.c: compile without -ffast-math and -ffinite-math-only; it tests its inputs for NaN and infinity"
#endif
#if defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#error "courier.c: compile without -funsafe-math-optimizations, -fassociative-math, -freciprocal-math: they change rounding"
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 1) && (FLT_EVAL_METHOD != 16)
#error "courier.c: compile for double arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif
#if defined(DBL_MANT_DIG) && (DBL_MANT_DIG != 53)
#error "courier.c: double is not IEEE-754's here, for which rounding is bounded"
#endif
/* No fused multiply-adds: Arduino's and other -std=gnu.. compilers would make them. */
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#pragma clang fp reassociate(off)
#elif defined(__GNUC__)
#pragma GCC optimize ("fp-contract=off")
#endif

/* B-spline control points divided by 6, one row for each of 64 + 3 points:
 * lower[0], upper[0], lower[1], upper[1]
 * Multiples of 2^-20: exact in float and double.
 */
static const courier_real courier_coefficients[268] = {
    0.008747100830078125, 0.1420602798461914, -0.01875782012939453, 0.11455535888671875,
    0.016676902770996094, 0.14999008178710938, 0.016676902770996094, 0.14999008178710938,
    0.024606704711914062, 0.15791988372802734, 0.05211162567138672, 0.1854248046875,
    0.03253650665283203, 0.1658496856689453, 0.08754634857177734, 0.22085857391357422,
    0.04046630859375, 0.17377948760986328, 0.12298107147216797, 0.25629329681396484,
    0.04839611053466797, 0.18170928955078125, 0.1584148406982422, 0.29172801971435547,
    0.05632591247558594, 0.18963909149169922, 0.1938495635986328, 0.3271627426147461,
    0.0642557144165039, 0.1975688934326172, 0.22928428649902344, 0.3625974655151367,
    0.07218551635742188, 0.20549869537353516, 0.26471900939941406, 0.39803218841552734,
    0.08011627197265625, 0.21342849731445312, 0.3001537322998047, 0.43346691131591797,
    0.08804607391357422, 0.2213582992553711, 0.3355884552001953, 0.4689016342163086,
    0.09597587585449219, 0.22928810119628906, 0.37102317810058594, 0.5043354034423828,
    0.10390567779541016, 0.23721885681152344, 0.40645790100097656, 0.5397701263427734,
    0.11183547973632812, 0.2451486587524414, 0.4418916702270508, 0.5752048492431641,
    0.1197652816772461, 0.2530784606933594, 0.4773263931274414, 0.6106395721435547,
    0.12769508361816406, 0.26100826263427734, 0.512761116027832, 0.6460742950439453,
    0.13562488555908203, 0.2689380645751953, 0.5481958389282227, 0.6815090179443359,
    0.1435546875, 0.2768678665161133, 0.5836305618286133, 0.7169437408447266,
    0.15148448944091797, 0.28479766845703125, 0.6190652847290039, 0.7523784637451172,
    0.15941429138183594, 0.2927274703979492, 0.6545000076293945, 0.7878122329711914,
    0.1673440933227539, 0.3006572723388672, 0.6899347305297852, 0.823246955871582,
    0.17527389526367188, 0.30858707427978516, 0.7222585678100586, 0.8555717468261719,
    0.18320369720458984, 0.3165168762207031, 0.7210617065429688, 0.854374885559082,
    0.18162155151367188, 0.31493473052978516, 0.7198638916015625, 0.8531770706176758,
    0.1800384521484375, 0.3133516311645508, 0.7186670303344727, 0.8519802093505859,
    0.1770153045654297, 0.31032848358154297, 0.7174701690673828, 0.8507833480834961,
    0.17399120330810547, 0.30730438232421875, 0.7162723541259766, 0.8495855331420898,
    0.1770162582397461, 0.3103294372558594, 0.7174720764160156, 0.8507843017578125,
    0.2427539825439453, 0.3760671615600586, 0.7257843017578125, 0.8590974807739258,
    0.30849170684814453, 0.4418048858642578, 0.7340965270996094, 0.8674097061157227,
    0.37422943115234375, 0.507542610168457, 0.7424087524414062, 0.8757219314575195,
    0.4399681091308594, 0.5732803344726562, 0.7507209777832031, 0.8840341567993164,
    0.5057058334350586, 0.6390190124511719, 0.7590341567993164, 0.8923463821411133,
    0.5714435577392578, 0.7047567367553711, 0.7673463821411133, 0.9006595611572266,
    0.637181282043457, 0.7704944610595703, 0.7756586074829102, 0.9089717864990234,
    0.7029190063476562, 0.8362321853637695, 0.783970832824707, 0.9172840118408203,
    0.7686576843261719, 0.9019699096679688, 0.7387418746948242, 0.8720550537109375,
    0.8343954086303711, 0.9677085876464844, 0.673004150390625, 0.8063173294067383,
    0.8280706405639648, 0.9613838195800781, 0.6072664260864258, 0.7405796051025391,
    0.821746826171875, 0.9550600051879883, 0.5415287017822266, 0.6748409271240234,
    0.8154220581054688, 0.948735237121582, 0.47579097747802734, 0.6091032028198242,
    0.8090982437133789, 0.9424114227294922, 0.4100522994995117, 0.543365478515625,
    0.8027744293212891, 0.9360866546630859, 0.3443145751953125, 0.4776277542114258,
    0.7964496612548828, 0.9297628402709961, 0.2785768508911133, 0.41189002990722656,
    0.790125846862793, 0.9234380722045898, 0.21283912658691406, 0.34615230560302734,
    0.7838010787963867, 0.9171142578125, 0.14710140228271484, 0.2804136276245117,
    0.7774772644042969, 0.9107894897460938, 0.08136272430419922, 0.2146759033203125,
    0.794468879699707, 0.9277820587158203, 0.015625, 0.14893817901611328,
    0.8114614486694336, 0.9447746276855469, 0.058823585510253906, 0.1921367645263672,
    0.8284540176391602, 0.9617671966552734, 0.10202312469482422, 0.2353353500366211,
    0.8454465866088867, 0.9787588119506836, 0.14522171020507812, 0.2785348892211914,
    0.8624382019042969, 0.9957513809204102, 0.18842029571533203, 0.3217334747314453,
    0.8794307708740234, 1.0127439498901367, 0.23161888122558594, 0.3649320602416992,
    0.89642333984375, 1.0297365188598633, 0.27481842041015625, 0.4081306457519531,
    0.9134149551391602, 1.0467281341552734, 0.31801700592041016, 0.45133018493652344,
    0.9304075241088867, 1.063720703125, 0.36121559143066406, 0.49452877044677734,
    0.9474000930786133, 1.0807132720947266, 0.40441417694091797, 0.5377273559570312,
    0.9643926620483398, 1.0977048873901367, 0.4476137161254883, 0.5809259414672852,
    0.98138427734375, 1.1146974563598633, 0.4908123016357422, 0.6241254806518555,
    0.9983768463134766, 1.1316900253295898, 0.5340108871459961, 0.6673240661621094,
    1.0153694152832031, 1.1486825942993164, 0.57720947265625, 0.7105226516723633,
    1.0323610305786133, 1.1656742095947266, 0.6204090118408203, 0.7537212371826172,
    1.0493535995483398, 1.1826667785644531, 0.6636075973510742, 0.7969207763671875,
    1.0663461685180664, 1.1996593475341797, 0.7068061828613281, 0.8401193618774414,
    1.083338737487793, 1.2166509628295898, 0.750004768371582, 0.8833179473876953,
    1.083338737487793, 1.2166509628295898, 0.750004768371582, 0.8833179473876953,
    1.083338737487793, 1.2166509628295898, 0.750004768371582, 0.8833179473876953
};

/* Covered starts have x strictly above these bounds, by component. */
static const courier_real courier_start_lower[2] = {
    0.10406081199646175, 0.10406081199646175
};

/* Covered starts have x strictly below these bounds, by component. */
static const courier_real courier_start_upper[2] = {
    0.895941095352171, 0.895941095352171
};

/* Spline time u = 64 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 64 (t_c = 24 s).
 */
static inline void courier_segment(courier_real t, int32_t *row, courier_real *s)
{
    const bool positive = 0.0 < t;
    const courier_real started = positive ? t : 0.0;
    const courier_real scaled = started * 2.6666666666666665;
    const bool early = scaled < 63.99999999999999;
    const courier_real u = early ? scaled : 63.99999999999999;
    const int32_t segment = (int32_t)u;
    const courier_real base = (courier_real)segment;
    const courier_real place = u - base;
    const int32_t first = segment * 4;
    *row = first;
    *s = place;
}

/* 6 times the uniform cubic B-spline basis at s in [0, 1]: weights >= 0 with sum 6. */
static inline void courier_basis(courier_real s, courier_real *w0, courier_real *w1, courier_real *w2,
                                 courier_real *w3)
{
    const courier_real v0 = 1.0 - s;
    const courier_real v1 = v0 * v0;
    const courier_real v2 = v1 * v0;
    const courier_real v3 = v0 * s;
    const courier_real v4 = 1.0 + v3;
    const courier_real v5 = 3.0 * v4;
    const courier_real v6 = v0 * v5;
    const courier_real v7 = 1.0 + v6;
    const courier_real v8 = s * v5;
    const courier_real v9 = 1.0 + v8;
    const courier_real v10 = s * s;
    const courier_real v11 = v10 * s;
    *w0 = v2;
    *w1 = v7;
    *w2 = v9;
    *w3 = v11;
}

/* Derivative of the weights with respect to s. */
static inline void courier_basis_rate(courier_real s, courier_real *dw0, courier_real *dw1, courier_real *dw2,
                                      courier_real *dw3)
{
    const courier_real v0 = 1.0 - s;
    const courier_real v1 = v0 + v0;
    const courier_real v2 = v0 * v1;
    const courier_real v3 = v0 * v0;
    const courier_real v4 = v2 + v3;
    const courier_real v5 = -v4;
    const courier_real v6 = v0 - s;
    const courier_real v7 = 3.0 * v6;
    const courier_real v8 = v0 * v7;
    const courier_real v9 = v0 * s;
    const courier_real v10 = 1.0 + v9;
    const courier_real v11 = 3.0 * v10;
    const courier_real v12 = v8 - v11;
    const courier_real v13 = s * v7;
    const courier_real v14 = v11 + v13;
    const courier_real v15 = s + s;
    const courier_real v16 = s * v15;
    const courier_real v17 = s * s;
    const courier_real v18 = v16 + v17;
    *dw0 = v5;
    *dw1 = v12;
    *dw2 = v14;
    *dw3 = v18;
}

/* An edge of the tube (or its slope in spline time): sum of w_j q_j,
 * of the control points that stand at `at` and one, two and three rows after it.
 */
static inline courier_real courier_edge_at(int32_t at, courier_real w0, courier_real w1, courier_real w2,
                                           courier_real w3)
{
    const courier_real q0 = courier_coefficients[at];
    const int32_t at_1 = at + 4;
    const courier_real q1 = courier_coefficients[at_1];
    const int32_t at_2 = at + 8;
    const courier_real q2 = courier_coefficients[at_2];
    const int32_t at_3 = at + 12;
    const courier_real q3 = courier_coefficients[at_3];
    const courier_real v0 = w0 * q0;
    const courier_real v1 = w1 * q1;
    const courier_real v2 = v0 + v1;
    const courier_real v3 = w2 * q2;
    const courier_real v4 = w3 * q3;
    const courier_real v5 = v3 + v4;
    const courier_real v6 = v2 + v5;
    return v6;
}

/* Normalized error e = (2 x - gamma_s) / gamma_d, from a = x - lower, b = upper - x. */
static inline courier_real courier_normalized_error(courier_real a, courier_real b, courier_real width)
{
    const courier_real v0 = a - b;
    const courier_real v1 = v0 / width;
    return v1;
}

/* Transformed error epsilon = ln((1 + e)/(1 - e)) = ln(a/b) and xi = d epsilon/dx = 1/a + 1/b. */
static inline void courier_transformed_error(courier_real a, courier_real b, courier_real *epsilon,
                                             courier_real *xi)
{
    const courier_real v0 = b / a;
    const courier_real v1 = log(v0);
    const courier_real v2 = -v1;
    const courier_real v3 = 1.0 + v0;
    const courier_real v4 = v3 / b;
    *epsilon = v2;
    *xi = v4;
}

/* Control law (13): u = -k xi epsilon. */
static inline courier_real courier_law(courier_real k, courier_real xi, courier_real epsilon)
{
    const courier_real v0 = k * xi;
    const courier_real v1 = v0 * epsilon;
    const courier_real v2 = -v1;
    return v2;
}

void courier_tube(courier_real t, courier_real lower[COURIER_N], courier_real upper[COURIER_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower[j] = (courier_real)NAN;
            upper[j] = (courier_real)NAN;
        }
        return;
    }
    int32_t row;
    courier_real s;
    courier_segment(t, &row, &s);
    courier_real w0;
    courier_real w1;
    courier_real w2;
    courier_real w3;
    courier_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const courier_real lower_edge = courier_edge_at(lower_at, w0, w1, w2, w3);
        const courier_real upper_edge = courier_edge_at(upper_at, w0, w1, w2, w3);
        lower[i] = lower_edge;
        upper[i] = upper_edge;
    }
}

void courier_tube_rate(courier_real t, courier_real lower_rate[COURIER_N], courier_real upper_rate[COURIER_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower_rate[j] = (courier_real)NAN;
            upper_rate[j] = (courier_real)NAN;
        }
        return;
    }
    int32_t row;
    courier_real s;
    courier_segment(t, &row, &s);
    courier_real dw0;
    courier_real dw1;
    courier_real dw2;
    courier_real dw3;
    courier_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    const bool moving = t < 24.0;
    const courier_real per_second = moving ? 2.6666666666666665 : 0.0;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const courier_real lower_slope = courier_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const courier_real lower_speed = lower_slope * per_second;
        const courier_real upper_slope = courier_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const courier_real upper_speed = upper_slope * per_second;
        lower_rate[i] = lower_speed;
        upper_rate[i] = upper_speed;
    }
}

courier_status courier_control(courier_real t, const courier_real x[COURIER_N], courier_real u[COURIER_N])
{
    const courier_real t_zero = t * 0.0;
    courier_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const courier_real x_j = x[j];
        const courier_real x_zero = x_j * 0.0;
        const courier_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 2; ++m) {
            u[m] = 0.0;
        }
        return COURIER_BAD_INPUT;
    }
    int32_t row;
    courier_real s;
    courier_segment(t, &row, &s);
    courier_real w0;
    courier_real w1;
    courier_real w2;
    courier_real w3;
    courier_basis(s, &w0, &w1, &w2, &w3);
    bool outside = false;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const courier_real lower_edge = courier_edge_at(lower_at, w0, w1, w2, w3);
        const courier_real upper_edge = courier_edge_at(upper_at, w0, w1, w2, w3);
        const courier_real x_i = x[i];
        const courier_real width = upper_edge - lower_edge;
        const courier_real to_lower = x_i - lower_edge;
        const courier_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const courier_real distance = upper_nearer ? to_upper : to_lower;
        const courier_real gain = upper_nearer ? (-0.5) : 0.5;
        const courier_real smallest = width * 0.005;
        const bool clear = smallest < distance;
        const courier_real to_nearer = clear ? distance : smallest;
        const courier_real to_farther = width - to_nearer;
        const bool inside = 0.0 < distance;
        const bool outside_next = inside ? outside : true;
        courier_real epsilon;
        courier_real xi;
        courier_transformed_error(to_nearer, to_farther, &epsilon, &xi);
        const courier_real u_i = courier_law(gain, xi, epsilon);
        u[i] = u_i;
        outside = outside_next;
    }
    return outside ? COURIER_OUTSIDE_TUBE : COURIER_OK;
}

courier_real courier_margin(courier_real t, const courier_real x[COURIER_N])
{
    const courier_real t_zero = t * 0.0;
    courier_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const courier_real x_j = x[j];
        const courier_real x_zero = x_j * 0.0;
        const courier_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0;
    const bool bad = !finite;
    if (bad) {
        return (courier_real)NAN;
    }
    int32_t row;
    courier_real s;
    courier_segment(t, &row, &s);
    courier_real w0;
    courier_real w1;
    courier_real w2;
    courier_real w3;
    courier_basis(s, &w0, &w1, &w2, &w3);
    courier_real margin = 0.5;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const courier_real lower_edge = courier_edge_at(lower_at, w0, w1, w2, w3);
        const courier_real upper_edge = courier_edge_at(upper_at, w0, w1, w2, w3);
        const courier_real x_i = x[i];
        const courier_real width = upper_edge - lower_edge;
        const courier_real to_lower = x_i - lower_edge;
        const courier_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const courier_real x_distance = x_nearer ? to_upper : to_lower;
        const courier_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0);
        const courier_real margin_x = x_beyond ? (-1.0) : x_share;
        const bool less = margin_x < margin;
        const courier_real margin_next = less ? margin_x : margin;
        margin = margin_next;
    }
    return margin;
}

void courier_margins(courier_real t, const courier_real x[COURIER_N], courier_real margin[COURIER_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            margin[j] = (courier_real)NAN;
        }
        return;
    }
    int32_t row;
    courier_real s;
    courier_segment(t, &row, &s);
    courier_real w0;
    courier_real w1;
    courier_real w2;
    courier_real w3;
    courier_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const courier_real lower_edge = courier_edge_at(lower_at, w0, w1, w2, w3);
        const courier_real upper_edge = courier_edge_at(upper_at, w0, w1, w2, w3);
        const courier_real x_i = x[i];
        const courier_real width = upper_edge - lower_edge;
        const courier_real to_lower = x_i - lower_edge;
        const courier_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const courier_real x_distance = x_nearer ? to_upper : to_lower;
        const courier_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0);
        const courier_real margin_x = x_beyond ? (-1.0) : x_share;
        margin[i] = margin_x;
    }
}

bool courier_covered(const courier_real x[COURIER_N])
{
    bool covered = true;
    for (int32_t i = 0; i < 2; ++i) {
        const courier_real x_i = x[i];
        const courier_real x_lower = courier_start_lower[i];
        const courier_real x_upper = courier_start_upper[i];
        const bool x_above = x_lower < x_i;
        const bool x_below = x_i < x_upper;
        const bool x_inside = x_above && x_below;
        const bool covered_next = x_inside ? covered : false;
        covered = covered_next;
    }
    return covered;
}

void courier_transform(const courier_real lower[COURIER_N], const courier_real upper[COURIER_N],
                       const courier_real x[COURIER_N], courier_real e[COURIER_N],
                       courier_real epsilon[COURIER_N], courier_real xi[COURIER_N])
{
    for (int32_t i = 0; i < 2; ++i) {
        const courier_real lower_edge = lower[i];
        const courier_real upper_edge = upper[i];
        const courier_real x_i = x[i];
        const courier_real width = upper_edge - lower_edge;
        const bool filled = 0.0 < width;
        const bool empty = !filled;
        const bool wide = 9.5367431640625e-7 < width;
        const courier_real safe_width = wide ? width : 9.5367431640625e-7;
        const courier_real to_lower = x_i - lower_edge;
        const courier_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const courier_real distance = upper_nearer ? to_upper : to_lower;
        const courier_real sign = upper_nearer ? (-1.0) : 1.0;
        const courier_real smallest = safe_width * 0.005;
        const courier_real widened = safe_width - width;
        const courier_real half = widened * 0.5;
        const courier_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const courier_real to_nearer = clear ? safe_distance : smallest;
        const courier_real to_farther = safe_width - to_nearer;
        const courier_real a = upper_nearer ? to_farther : to_nearer;
        const courier_real b = upper_nearer ? to_nearer : to_farther;
        const courier_real e_i = courier_normalized_error(a, b, safe_width);
        const bool e_above = (-0.99) < e_i;
        const courier_real e_raised = e_above ? e_i : (-0.99);
        const bool e_beyond = 0.99 < e_raised;
        const courier_real e_limited = e_beyond ? 0.99 : e_raised;
        courier_real epsilon_nearer;
        courier_real xi_i;
        courier_transformed_error(to_nearer, to_farther, &epsilon_nearer, &xi_i);
        const courier_real epsilon_i = sign * epsilon_nearer;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_width = isfinite(width) != 0;
        const bool finite = finite_x && finite_width;
        const courier_real e_or_zero = empty ? 0.0 : e_limited;
        const courier_real e_out = finite ? e_or_zero : (courier_real)NAN;
        e[i] = e_out;
        const courier_real epsilon_or_zero = empty ? 0.0 : epsilon_i;
        const courier_real epsilon_out = finite ? epsilon_or_zero : (courier_real)NAN;
        epsilon[i] = epsilon_out;
        const courier_real xi_or_zero = empty ? 0.0 : xi_i;
        const courier_real xi_out = finite ? xi_or_zero : (courier_real)NAN;
        xi[i] = xi_out;
    }
}
