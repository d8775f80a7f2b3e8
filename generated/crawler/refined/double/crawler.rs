//! crawler: prescribed-time reach-avoid-stay controller, refined tube, double precision.
//!
//! Certified (crawler.certificate.json): for every t the tube keeps 0.05 from every
//! unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
//! The state stays in it (P9) sampled every 0.005 s or faster, from every start with |e(0)| <= 0.9, for |f +
//! w| <= 0.1, 0.95 <= g_ii <= 1.05, |g_ij| <= 0, x measured to 0.002: |e| < 0.9001, |u| <= 1.3.
//!
//! Call `control` once every period with the time since the start and the measured state.
//! Nothing allocates, nothing is unsafe, no loop depends on data. Numbers in brackets are equations of Das and Jagtap, IEEE
//! L-CSS 8, 2024.
#![no_std]
#![cfg_attr(rustfmt, rustfmt_skip)]
#![forbid(unsafe_code)]
// One statement a line, every value assigned once, as in crawler.c; constants are those of the table; the name is the task's.
#![allow(non_snake_case, clippy::let_and_return, clippy::too_many_arguments, clippy::approx_constant, clippy::excessive_precision)]

pub type Real = f64;

pub const N: usize = 2;
/// Prescribed time, seconds.
pub const T_C: Real = 6.0;
/// Seconds of one tick of `control_tick`.
pub const TICK_PERIOD: Real = 0.001;
/// The first tick that is not before `T_C`.
pub const TICKS: u32 = 6000;
/// Seconds between samples, at most: from which starts, see above (P9).
pub const PERIOD_PROVED: Real = 0.004999999999999999;
/// 0.9, rounded down, of the tube's half widths at t = 0: the starts of `covered`.
pub const SHARE: Real = 0.8999999999999999;
/// Log it: names this design.
pub const DESIGN_HASH: &str = "dbb8a86162c3b17a";

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Status {
    Ok = 0,
    OutsideTube = 1,
    BadInput = 2,
}

// B-spline control points divided by 6, one row for each of 32 + 3 points:
// lower[0], upper[0], lower[1], upper[1]
// Multiples of 2^-21: exact in float and double.
static COEFFICIENTS: [Real; 140] = [
    -0.009665489196777344, 0.1619091033935547, -0.0220184326171875, 0.14955615997314453,
    5.245208740234375e-6, 0.16666173934936523, 5.245208740234375e-6, 0.16666173934936523,
    0.00967550277709961, 0.17141389846801758, 0.02202892303466797, 0.18376731872558594,
    0.019346237182617188, 0.17616653442382812, 0.0440521240234375, 0.20087289810180664,
    0.029016494750976562, 0.18091917037963867, 0.06607580184936523, 0.21797847747802734,
    0.03868722915649414, 0.18567132949829102, 0.08809947967529297, 0.23508405685424805,
    0.048357486724853516, 0.19042396545410156, 0.1101231575012207, 0.25218963623046875,
    0.058028221130371094, 0.1951766014099121, 0.13214683532714844, 0.26929521560668945,
    0.06769847869873047, 0.19992923736572266, 0.15417051315307617, 0.28640079498291016,
    0.07736921310424805, 0.204681396484375, 0.1761941909790039, 0.30350637435913086,
    0.08703994750976562, 0.20943403244018555, 0.19821786880493164, 0.32061195373535156,
    0.096710205078125, 0.2141866683959961, 0.22024154663085938, 0.33771753311157227,
    0.10638093948364258, 0.21893882751464844, 0.2422652244567871, 0.35482311248779297,
    0.11605119705200195, 0.22860956192016602, 0.26428890228271484, 0.3768467903137207,
    0.12572193145751953, 0.2382798194885254, 0.2863121032714844, 0.39887046813964844,
    0.14577245712280273, 0.2583308219909668, 0.3083357810974121, 0.42089414596557617,
    0.16582345962524414, 0.27838134765625, 0.33035945892333984, 0.4429178237915039,
    0.18587398529052734, 0.2984323501586914, 0.3523831367492676, 0.46494150161743164,
    0.20592498779296875, 0.3184828758239746, 0.35822582244873047, 0.47078418731689453,
    0.22597551345825195, 0.338533878326416, 0.36406850814819336, 0.4766268730163574,
    0.24602651596069336, 0.3585844039916992, 0.36991119384765625, 0.4824695587158203,
    0.26607704162597656, 0.3786354064941406, 0.37575387954711914, 0.4883122444152832,
    0.28612804412841797, 0.39868593215942383, 0.38159656524658203, 0.4941549301147461,
    0.30617856979370117, 0.41873693466186523, 0.3874392509460449, 0.499997615814209,
    0.3262295722961426, 0.43878746032714844, 0.3874392509460449, 0.499997615814209,
    0.3462800979614258, 0.45883846282958984, 0.3874392509460449, 0.499997615814209,
    0.3663311004638672, 0.47888898849487305, 0.3874392509460449, 0.499997615814209,
    0.3863816261291504, 0.49893999099731445, 0.3874392509460449, 0.499997615814209,
    0.4064326286315918, 0.5189905166625977, 0.3874392509460449, 0.499997615814209,
    0.426483154296875, 0.5390415191650391, 0.3874392509460449, 0.499997615814209,
    0.4465341567993164, 0.5590920448303223, 0.3874392509460449, 0.499997615814209,
    0.4665846824645996, 0.5791430473327637, 0.3874392509460449, 0.499997615814209,
    0.486635684967041, 0.5991935729980469, 0.3874392509460449, 0.499997615814209,
    0.5066862106323242, 0.6192440986633301, 0.3874392509460449, 0.499997615814209,
    0.486635684967041, 0.5991935729980469, 0.3874392509460449, 0.499997615814209,
];

// Gain k of the control law, by component.
static GAIN: [Real; 2] = [
    0.0388, 0.0623,
];

// Saturation of u, by component.
static U_MAX: [Real; 2] = [
    1.2999999999999998, 1.2999999999999998,
];

// Covered starts have x strictly above these bounds, by component.
static START_LOWER: [Real; 2] = [
    0.05202794265747159, 0.052028419494629795,
];

// Covered starts have x strictly below these bounds, by component.
static START_UPPER: [Real; 2] = [
    0.9479730110168447, 0.9479734878540029,
];

/// y = m 2^e with m in [1/sqrt 2, sqrt 2), for y not below that: e.
#[inline]
fn exponent(y: Real) -> i32 {
    ((y.to_bits() - 0x3fe6_a09e_667f_3bcd) >> 52) as i32
}

/// And m.
#[inline]
fn mantissa(y: Real) -> Real {
    Real::from_bits(((y.to_bits() - 0x3fe6_a09e_667f_3bcd) & 0xfffffffffffff) + 0x3fe6_a09e_667f_3bcd)
}

// Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
// Before 0 the start; from t_c on the last number below 32 (t_c = 6 s).
#[inline]
fn segment(t: Real) -> (i32, Real) {
    let positive: bool = 0.0 < t;
    let started: Real = if positive { t } else { 0.0 };
    let scaled: Real = started * 5.333333333333333;
    let early: bool = scaled < 31.999999999999996;
    let u: Real = if early { scaled } else { 31.999999999999996 };
    let segment: i32 = u as i32;
    let base: Real = segment as Real;
    let place: Real = u - base;
    let first: i32 = segment * 4;
    (first, place)
}

// As segment, for a count of ticks: one is 2/375 of a segment, in integers; only s is rounded.
// From tick 6000 on the last segment and s = 1, which is t_c.
#[inline]
fn segment_at_tick(tick: u32) -> (i32, Real) {
    let running: bool = tick < 6000;
    let held: u32 = if running { tick } else { 6000 };
    let count: i32 = held as i32;
    let passed: i32 = count * 2;
    let early: bool = passed < 12000;
    let place: i32 = if early { passed } else { 12000 };
    let whole: i32 = place / 375;
    let before_last: bool = whole < 31;
    let segment: i32 = if before_last { whole } else { 31 };
    let base: i32 = segment * 375;
    let rest: i32 = place - base;
    let part: Real = rest as Real;
    let share: Real = part / 375.0;
    let first: i32 = segment * 4;
    (first, share)
}

// 6 times the uniform cubic B-spline basis at s in [0, 1]: weights >= 0 with sum 6.
#[inline]
fn basis(s: Real) -> (Real, Real, Real, Real) {
    let v0: Real = 1.0 - s;
    let v1: Real = v0 * v0;
    let v2: Real = v1 * v0;
    let v3: Real = v0 * s;
    let v4: Real = 1.0 + v3;
    let v5: Real = 3.0 * v4;
    let v6: Real = v0 * v5;
    let v7: Real = 1.0 + v6;
    let v8: Real = s * v5;
    let v9: Real = 1.0 + v8;
    let v10: Real = s * s;
    let v11: Real = v10 * s;
    (v2, v7, v9, v11)
}

// Derivative of the weights with respect to s.
#[inline]
fn basis_rate(s: Real) -> (Real, Real, Real, Real) {
    let v0: Real = 1.0 - s;
    let v1: Real = v0 + v0;
    let v2: Real = v0 * v1;
    let v3: Real = v0 * v0;
    let v4: Real = v2 + v3;
    let v5: Real = -v4;
    let v6: Real = v0 - s;
    let v7: Real = 3.0 * v6;
    let v8: Real = v0 * v7;
    let v9: Real = v0 * s;
    let v10: Real = 1.0 + v9;
    let v11: Real = 3.0 * v10;
    let v12: Real = v8 - v11;
    let v13: Real = s * v7;
    let v14: Real = v11 + v13;
    let v15: Real = s + s;
    let v16: Real = s * v15;
    let v17: Real = s * s;
    let v18: Real = v16 + v17;
    (v5, v12, v14, v18)
}

// An edge of the tube (or its slope in spline time): sum of w_j q_j,
// of the control points that stand at `at` and one, two and three rows after it.
#[inline]
fn edge_at(at: i32, w0: Real, w1: Real, w2: Real, w3: Real) -> Real {
    let q0: Real = COEFFICIENTS[at as usize];
    let at_1: i32 = at + 4;
    let q1: Real = COEFFICIENTS[at_1 as usize];
    let at_2: i32 = at + 8;
    let q2: Real = COEFFICIENTS[at_2 as usize];
    let at_3: i32 = at + 12;
    let q3: Real = COEFFICIENTS[at_3 as usize];
    let v0: Real = w0 * q0;
    let v1: Real = w1 * q1;
    let v2: Real = v0 + v1;
    let v3: Real = w2 * q2;
    let v4: Real = w3 * q3;
    let v5: Real = v3 + v4;
    let v6: Real = v2 + v5;
    v6
}

// Normalized error e = (2 x - gamma_s) / gamma_d, from a = x - lower, b = upper - x.
#[inline]
fn normalized_error(a: Real, b: Real, width: Real) -> Real {
    let v0: Real = a - b;
    let v1: Real = v0 / width;
    v1
}

// Transformed error epsilon = ln((1 + e)/(1 - e)) = ln(a/b) and xi = d epsilon/dx = 1/a + 1/b.
// ln y by y = m 2^e as e ln 2 + 2 atanh((m - 1)/(m + 1)), with a relative error below 2^-14.
#[inline]
fn transformed_error(a: Real, b: Real) -> (Real, Real) {
    let v0: Real = b / a;
    let exponent: i32 = exponent(v0);
    let base: Real = exponent as Real;
    let mantissa: Real = mantissa(v0);
    let below: Real = mantissa - 1.0;
    let above: Real = mantissa + 1.0;
    let s: Real = below / above;
    let z: Real = s * s;
    let bent: Real = z * 0.6766043901443481;
    let around: Real = bent + 2.0;
    let part: Real = s * around;
    let whole: Real = base * 0.6931471805599453;
    let v1: Real = whole + part;
    let v2: Real = -v1;
    let v3: Real = 1.0 + v0;
    let v4: Real = v3 / b;
    (v2, v4)
}

// Control law (13): u = -k xi epsilon.
#[inline]
fn law(k: Real, xi: Real, epsilon: Real) -> Real {
    let v0: Real = k * xi;
    let v1: Real = v0 * epsilon;
    let v2: Real = -v1;
    v2
}

/// Edges of the tube gamma at time t (seconds), in the task's units.
/// t below 0 counts as 0 and above t_c as t_c; NaN when t is not finite.
#[must_use]
pub fn tube(t: Real) -> ([Real; 2], [Real; 2]) {
    let mut lower: [Real; 2] = [0.0; 2];
    let mut upper: [Real; 2] = [0.0; 2];
    let finite: bool = t.is_finite();
    let bad: bool = !finite;
    if bad {
        for j in 0..2 {
            lower[j as usize] = Real::NAN;
            upper[j as usize] = Real::NAN;
        }
        return (lower, upper);
    }
    let (row, s) = self::segment(t);
    let (w0, w1, w2, w3) = self::basis(s);
    for i in 0..2 {
        let pair: i32 = i * 2;
        let lower_at: i32 = row + pair;
        let upper_at: i32 = lower_at + 1;
        let lower_edge = self::edge_at(lower_at, w0, w1, w2, w3);
        let upper_edge = self::edge_at(upper_at, w0, w1, w2, w3);
        lower[i as usize] = lower_edge;
        upper[i as usize] = upper_edge;
    }
    (lower, upper)
}

/// Rate of change of the edges, d gamma / d t, at time t (seconds), in units per second.
/// The rate at 0 before that and zero from t_c on; NaN when t is not finite.
#[must_use]
pub fn tube_rate(t: Real) -> ([Real; 2], [Real; 2]) {
    let mut lower_rate: [Real; 2] = [0.0; 2];
    let mut upper_rate: [Real; 2] = [0.0; 2];
    let finite: bool = t.is_finite();
    let bad: bool = !finite;
    if bad {
        for j in 0..2 {
            lower_rate[j as usize] = Real::NAN;
            upper_rate[j as usize] = Real::NAN;
        }
        return (lower_rate, upper_rate);
    }
    let (row, s) = self::segment(t);
    let (dw0, dw1, dw2, dw3) = self::basis_rate(s);
    let moving: bool = t < 6.0;
    let per_second: Real = if moving { 5.333333333333333 } else { 0.0 };
    for i in 0..2 {
        let pair: i32 = i * 2;
        let lower_at: i32 = row + pair;
        let upper_at: i32 = lower_at + 1;
        let lower_slope = self::edge_at(lower_at, dw0, dw1, dw2, dw3);
        let lower_speed: Real = lower_slope * per_second;
        let upper_slope = self::edge_at(upper_at, dw0, dw1, dw2, dw3);
        let upper_speed: Real = upper_slope * per_second;
        lower_rate[i as usize] = lower_speed;
        upper_rate[i as usize] = upper_speed;
    }
    (lower_rate, upper_rate)
}

/// Control law (13), u = -k xi epsilon, k = [0.0388, 0.0623], e clamped to [-0.99, 0.99] by component, u saturated.
/// t: seconds since the start (held within [0, t_c]); x: state; u: input.
/// OK: x strictly inside the tube. OUTSIDE_TUBE: not so; u is the clamped law, finite, and points inward
/// (0 where the tube is empty). BAD_INPUT: t or x has a NaN or an infinity; u is 0. u may be the array x itself.
#[must_use]
pub fn control(t: Real, x: &[Real; 2]) -> ([Real; 2], Status) {
    let mut u: [Real; 2] = [0.0; 2];
    let t_zero: Real = t * 0.0;
    let mut zero: Real = t_zero;
    for j in 0..2 {
        let x_j: Real = x[j as usize];
        let x_zero: Real = x_j * 0.0;
        let zeros: Real = zero + x_zero;
        zero = zeros;
    }
    let finite: bool = zero <= 0.0;
    let bad: bool = !finite;
    if bad {
        for m in 0..2 {
            u[m as usize] = 0.0;
        }
        return (u, Status::BadInput);
    }
    let (row, s) = self::segment(t);
    let (w0, w1, w2, w3) = self::basis(s);
    let mut outside: bool = false;
    for i in 0..2 {
        let pair: i32 = i * 2;
        let lower_at: i32 = row + pair;
        let upper_at: i32 = lower_at + 1;
        let lower_edge = self::edge_at(lower_at, w0, w1, w2, w3);
        let upper_edge = self::edge_at(upper_at, w0, w1, w2, w3);
        let x_i: Real = x[i as usize];
        let gain_i: Real = GAIN[i as usize];
        let gain_minus: Real = -gain_i;
        let width: Real = upper_edge - lower_edge;
        let to_lower: Real = x_i - lower_edge;
        let to_upper: Real = upper_edge - x_i;
        let upper_nearer: bool = to_upper < to_lower;
        let distance: Real = if upper_nearer { to_upper } else { to_lower };
        let gain: Real = if upper_nearer { gain_minus } else { gain_i };
        let smallest: Real = width * 0.005;
        let clear: bool = smallest < distance;
        let to_nearer: Real = if clear { distance } else { smallest };
        let to_farther: Real = width - to_nearer;
        let inside: bool = 0.0 < distance;
        let outside_next: bool = if inside { outside } else { true };
        let u_limit: Real = U_MAX[i as usize];
        let (epsilon, xi) = self::transformed_error(to_nearer, to_farther);
        let u_i = self::law(gain, xi, epsilon);
        let u_min: Real = -u_limit;
        let u_above: bool = u_min < u_i;
        let u_raised: Real = if u_above { u_i } else { u_min };
        let u_beyond: bool = u_limit < u_raised;
        let u_limited: Real = if u_beyond { u_limit } else { u_raised };
        u[i as usize] = u_limited;
        outside = outside_next;
    }
    (u, if outside { Status::OutsideTube } else { Status::Ok })
}

/// Control law (13), u = -k xi epsilon, k = [0.0388, 0.0623], e clamped to [-0.99, 0.99] by component, u saturated.
/// tick: periods of 0.001 s since the start (it must not wrap to 0: stop counting at t_c); x: state; u: input.
/// OK: x strictly inside the tube. OUTSIDE_TUBE: not so; u is the clamped law, finite, and points inward
/// (0 where the tube is empty). BAD_INPUT: x has a NaN or an infinity; u is 0. u may be the array x itself.
#[must_use]
pub fn control_tick(tick: u32, x: &[Real; 2]) -> ([Real; 2], Status) {
    let mut u: [Real; 2] = [0.0; 2];
    let mut zero: Real = 0.0;
    for j in 0..2 {
        let x_j: Real = x[j as usize];
        let x_zero: Real = x_j * 0.0;
        let zeros: Real = zero + x_zero;
        zero = zeros;
    }
    let finite: bool = zero <= 0.0;
    let bad: bool = !finite;
    if bad {
        for m in 0..2 {
            u[m as usize] = 0.0;
        }
        return (u, Status::BadInput);
    }
    let (row, s) = self::segment_at_tick(tick);
    let (w0, w1, w2, w3) = self::basis(s);
    let mut outside: bool = false;
    for i in 0..2 {
        let pair: i32 = i * 2;
        let lower_at: i32 = row + pair;
        let upper_at: i32 = lower_at + 1;
        let lower_edge = self::edge_at(lower_at, w0, w1, w2, w3);
        let upper_edge = self::edge_at(upper_at, w0, w1, w2, w3);
        let x_i: Real = x[i as usize];
        let gain_i: Real = GAIN[i as usize];
        let gain_minus: Real = -gain_i;
        let width: Real = upper_edge - lower_edge;
        let to_lower: Real = x_i - lower_edge;
        let to_upper: Real = upper_edge - x_i;
        let upper_nearer: bool = to_upper < to_lower;
        let distance: Real = if upper_nearer { to_upper } else { to_lower };
        let gain: Real = if upper_nearer { gain_minus } else { gain_i };
        let smallest: Real = width * 0.005;
        let clear: bool = smallest < distance;
        let to_nearer: Real = if clear { distance } else { smallest };
        let to_farther: Real = width - to_nearer;
        let inside: bool = 0.0 < distance;
        let outside_next: bool = if inside { outside } else { true };
        let u_limit: Real = U_MAX[i as usize];
        let (epsilon, xi) = self::transformed_error(to_nearer, to_farther);
        let u_i = self::law(gain, xi, epsilon);
        let u_min: Real = -u_limit;
        let u_above: bool = u_min < u_i;
        let u_raised: Real = if u_above { u_i } else { u_min };
        let u_beyond: bool = u_limit < u_raised;
        let u_limited: Real = if u_beyond { u_limit } else { u_raised };
        u[i as usize] = u_limited;
        outside = outside_next;
    }
    (u, if outside { Status::OutsideTube } else { Status::Ok })
}

/// How far x is from leaving the tube: the distance to the nearest edge over the tube's width there, least over the
/// components. 0.5 in the middle, positive inside, negative outside, at least -1; NaN when an argument is not finite.
/// Watch it: act while there is margin, not when the tube is left.
#[must_use]
pub fn margin(t: Real, x: &[Real; 2]) -> Real {
    let t_zero: Real = t * 0.0;
    let mut zero: Real = t_zero;
    for j in 0..2 {
        let x_j: Real = x[j as usize];
        let x_zero: Real = x_j * 0.0;
        let zeros: Real = zero + x_zero;
        zero = zeros;
    }
    let finite: bool = zero <= 0.0;
    let bad: bool = !finite;
    if bad {
        return Real::NAN;
    }
    let (row, s) = self::segment(t);
    let (w0, w1, w2, w3) = self::basis(s);
    let mut margin: Real = 0.5;
    for i in 0..2 {
        let pair: i32 = i * 2;
        let lower_at: i32 = row + pair;
        let upper_at: i32 = lower_at + 1;
        let lower_edge = self::edge_at(lower_at, w0, w1, w2, w3);
        let upper_edge = self::edge_at(upper_at, w0, w1, w2, w3);
        let x_i: Real = x[i as usize];
        let width: Real = upper_edge - lower_edge;
        let to_lower: Real = x_i - lower_edge;
        let to_upper: Real = upper_edge - x_i;
        let x_nearer: bool = to_upper < to_lower;
        let x_distance: Real = if x_nearer { to_upper } else { to_lower };
        let x_share: Real = x_distance / width;
        let x_beyond: bool = x_share < -1.0;
        let margin_x: Real = if x_beyond { -1.0 } else { x_share };
        let less: bool = margin_x < margin;
        let margin_next: Real = if less { margin_x } else { margin };
        margin = margin_next;
    }
    margin
}

/// The margin of each component: which axis is near its edge. NaN where that component of the state is NaN; in all
/// components where another argument is not finite.
#[must_use]
pub fn margins(t: Real, x: &[Real; 2]) -> [Real; 2] {
    let mut margin: [Real; 2] = [0.0; 2];
    let finite: bool = t.is_finite();
    let bad: bool = !finite;
    if bad {
        for j in 0..2 {
            margin[j as usize] = Real::NAN;
        }
        return margin;
    }
    let (row, s) = self::segment(t);
    let (w0, w1, w2, w3) = self::basis(s);
    for i in 0..2 {
        let pair: i32 = i * 2;
        let lower_at: i32 = row + pair;
        let upper_at: i32 = lower_at + 1;
        let lower_edge = self::edge_at(lower_at, w0, w1, w2, w3);
        let upper_edge = self::edge_at(upper_at, w0, w1, w2, w3);
        let x_i: Real = x[i as usize];
        let width: Real = upper_edge - lower_edge;
        let to_lower: Real = x_i - lower_edge;
        let to_upper: Real = upper_edge - x_i;
        let x_nearer: bool = to_upper < to_lower;
        let x_distance: Real = if x_nearer { to_upper } else { to_lower };
        let x_share: Real = x_distance / width;
        let x_beyond: bool = x_share < -1.0;
        let margin_x: Real = if x_beyond { -1.0 } else { x_share };
        margin[i as usize] = margin_x;
    }
    margin
}

/// Whether the proof of the sampling period (P9) covers a start at the measured x:
/// every component of x is within 0.9 of the tube's half width about its middle at t = 0.
/// What a measurement may be wrong by (rounding and the noise of [plant]) is taken off.
/// Ask before the first step. Where it says false, nothing is proved of this start: move the robot, or design a tube
/// from where it stands. False for a NaN.
#[must_use]
pub fn covered(x: &[Real; 2]) -> bool {
    let mut covered: bool = true;
    for i in 0..2 {
        let x_i: Real = x[i as usize];
        let x_lower: Real = START_LOWER[i as usize];
        let x_upper: Real = START_UPPER[i as usize];
        let x_above: bool = x_lower < x_i;
        let x_below: bool = x_i < x_upper;
        let x_inside: bool = x_above && x_below;
        let covered_next: bool = if x_inside { covered } else { false };
        covered = covered_next;
    }
    covered
}

/// Error transform of section IV for the state x in the box (lower, upper), by component:
///   e       = (2 x - (upper + lower)) / (upper - lower), clamped to [-e_max, e_max]
///   epsilon = ln((1 + e) / (1 - e))
///   xi      = 4 / ((upper - lower) (1 - e^2)) = d epsilon / dx
/// 0 in a component with upper <= lower; a width below 2^-20 counts as that.
/// NaN where an edge, x or upper - lower is not finite.
#[must_use]
pub fn transform(
    lower: &[Real; 2],
    upper: &[Real; 2],
    x: &[Real; 2],
) -> ([Real; 2], [Real; 2], [Real; 2]) {
    let mut e: [Real; 2] = [0.0; 2];
    let mut epsilon: [Real; 2] = [0.0; 2];
    let mut xi: [Real; 2] = [0.0; 2];
    for i in 0..2 {
        let lower_edge: Real = lower[i as usize];
        let upper_edge: Real = upper[i as usize];
        let x_i: Real = x[i as usize];
        let width: Real = upper_edge - lower_edge;
        let filled: bool = 0.0 < width;
        let empty: bool = !filled;
        let wide: bool = 9.5367431640625e-7 < width;
        let safe_width: Real = if wide { width } else { 9.5367431640625e-7 };
        let to_lower: Real = x_i - lower_edge;
        let to_upper: Real = upper_edge - x_i;
        let upper_nearer: bool = to_upper < to_lower;
        let distance: Real = if upper_nearer { to_upper } else { to_lower };
        let sign: Real = if upper_nearer { -1.0 } else { 1.0 };
        let smallest: Real = safe_width * 0.005;
        let widened: Real = safe_width - width;
        let half: Real = widened * 0.5;
        let safe_distance: Real = distance + half;
        let farther: bool = smallest < safe_distance;
        let clear: bool = filled && farther;
        let to_nearer: Real = if clear { safe_distance } else { smallest };
        let to_farther: Real = safe_width - to_nearer;
        let a: Real = if upper_nearer { to_farther } else { to_nearer };
        let b: Real = if upper_nearer { to_nearer } else { to_farther };
        let e_i = self::normalized_error(a, b, safe_width);
        let e_above: bool = -0.99 < e_i;
        let e_raised: Real = if e_above { e_i } else { -0.99 };
        let e_beyond: bool = 0.99 < e_raised;
        let e_limited: Real = if e_beyond { 0.99 } else { e_raised };
        let (epsilon_nearer, xi_i) = self::transformed_error(to_nearer, to_farther);
        let epsilon_i: Real = sign * epsilon_nearer;
        let finite_x: bool = x_i.is_finite();
        let finite_width: bool = width.is_finite();
        let finite: bool = finite_x && finite_width;
        let e_or_zero: Real = if empty { 0.0 } else { e_limited };
        let e_out: Real = if finite { e_or_zero } else { Real::NAN };
        e[i as usize] = e_out;
        let epsilon_or_zero: Real = if empty { 0.0 } else { epsilon_i };
        let epsilon_out: Real = if finite { epsilon_or_zero } else { Real::NAN };
        epsilon[i as usize] = epsilon_out;
        let xi_or_zero: Real = if empty { 0.0 } else { xi_i };
        let xi_out: Real = if finite { xi_or_zero } else { Real::NAN };
        xi[i as usize] = xi_out;
    }
    (e, epsilon, xi)
}
