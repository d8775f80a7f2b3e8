What only a controller for a plant of order 2 has: it holds z = v + lambda x between L' + lambda L and R' + lambda R.

== edges and rates
        <<edges>>
        const P_real lower_slope = P_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const P_real lower_rate = lower_slope * $per_second;
        const P_real upper_slope = P_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const P_real upper_rate = upper_slope * $per_second;

== filtered tube
void P_filtered_tube(P_real t, P_real lower[M_N], P_real upper[M_N])
{
    <<NaN unless t is finite>>
            lower[j] = (P_real)NAN;
            upper[j] = (P_real)NAN;
        }
        return;
    }
    <<segment and s>>
    <<weights>>
    <<rates>>
    for (int32_t i = 0; i < $n; ++i) {
        <<edges and rates>>
        const P_real filter_i = P_filter[i];  [filters]
        const P_real lower_part = lower_edge * filter_i;  [filters]
        const P_real lower_part = lower_edge * $filter;  [one filter]
        const P_real z_lower = lower_rate + lower_part;
        lower[i] = z_lower;
        const P_real upper_part = upper_edge * filter_i;  [filters]
        const P_real upper_part = upper_edge * $filter;  [one filter]
        const P_real z_upper = upper_rate + upper_part;
        upper[i] = z_upper;
    }
}

== velocity
/* By differences; NaN where dt is not positive. */
void P_velocity(P_real dt, const P_real x[M_N], const P_real x_before[M_N], P_real v[M_N])
{
    const bool positive = 0.0 < dt;
    const P_real step = positive ? dt : 1.0;
    for (int32_t i = 0; i < $n; ++i) {
        const P_real x_i = x[i];
        const P_real x_before_i = x_before[i];
        const P_real moved = x_i - x_before_i;
        const P_real mean = moved / step;
        const P_real v_i = positive ? mean : (P_real)NAN;
        v[i] = v_i;
    }
}

== sum of zeros of v
    P_real v_zeros = zero;
    for (int32_t k = 0; k < $n; ++k) {
        const P_real v_k = v[k];
        const P_real v_zero = v_k * 0.0;
        const P_real v_sum = v_zeros + v_zero;
        v_zeros = v_sum;
    }

== distances
/* Of x to its edges, and of v to their rates. */
        <<edges and rates>>
        const P_real x_i = x[i];
        const P_real v_i = v[i];
        const P_real width = upper_edge - lower_edge;
        const P_real to_lower = x_i - lower_edge;
        const P_real to_upper = upper_edge - x_i;
        const P_real v_width = upper_rate - lower_rate;
        const P_real v_to_lower = v_i - lower_rate;
        const P_real v_to_upper = upper_rate - v_i;
        const P_real filter_i = P_filter[i];  [filters]

== filtered distances
/* Of v + lambda x to the edges of its tube. */
        const P_real width_part = width * filter_i;  [filters]
        const P_real width_part = width * $filter;  [one filter]
        const P_real z_width = v_width + width_part;
        const P_real lower_part = to_lower * filter_i;  [filters]
        const P_real lower_part = to_lower * $filter;  [one filter]
        const P_real z_to_lower = v_to_lower + lower_part;
        const P_real upper_part = to_upper * filter_i;  [filters]
        const P_real upper_part = to_upper * $filter;  [one filter]
        const P_real z_to_upper = v_to_upper + upper_part;

== state and rate between the edges
        <<distances>>
        const P_real least_share_i = P_least_share[i];  [clamps]
        const P_real gain_i = P_gain[i];  [gains]
        const P_real gain_minus = -gain_i;  [gains]
        <<filtered distances>>
        const bool upper_nearer = z_to_upper < z_to_lower;
        const P_real distance = upper_nearer ? z_to_upper : z_to_lower;
        const P_real gain = upper_nearer ? gain_minus : gain_i;  [gains]
        const P_real gain = upper_nearer ? $gain_minus : $gain;  [one gain]
        const P_real smallest = z_width * least_share_i;  [clamps]
        const P_real smallest = z_width * $smallest_share;  [one clamp]
        const bool clear = smallest < distance;
        const P_real to_nearer = clear ? distance : smallest;
        const P_real to_farther = z_width - to_nearer;
        const bool x_above = 0.0 < to_lower;
        const bool x_below = 0.0 < to_upper;
        const bool x_inside = x_above && x_below;
        const bool z_inside = 0.0 < distance;
        const bool inside = z_inside && x_inside;
        const bool outside_next = inside ? outside : true;

== margin of v + lambda x
        const bool z_nearer = z_to_upper < z_to_lower;
        const P_real z_distance = z_nearer ? z_to_upper : z_to_lower;
        const P_real z_share = z_distance / z_width;
        const bool z_beyond = z_share < (-1.0);
        const P_real margin_z = z_beyond ? (-1.0) : z_share;

== smaller margin
        const bool x_smaller = margin_x < margin_z;
        const P_real smaller = x_smaller ? margin_x : margin_z;

== start of v + lambda x
        const P_real filter_i = P_filter[i];  [filters]
        const P_real x_part = x_i * filter_i;  [filters]
        const P_real x_part = x_i * $filter;  [one filter]
        const P_real v_i = v[i];
        const P_real z_i = v_i + x_part;
        const P_real z_lower = P_filtered_start_lower[i];
        const P_real z_upper = P_filtered_start_upper[i];
        const bool z_above = z_lower < z_i;
        const bool z_below = z_i < z_upper;
        const bool z_inside = z_above && z_below;
        const bool inside = x_inside && z_inside;
