/* waypoints.c: prescribed-time reach-avoid-stay controller, refined tube, double precision.
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
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 1) && (FLT_EVAL_METHOD != 16)
#error "waypoints.c: compile for double arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif
#if defined(DBL_MANT_DIG) && (DBL_MANT_DIG != 53)
#error "waypoints.c: double is not IEEE-754's here, for which rounding is bounded"
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
    0.6667098999023438, 0.8332977294921875, 0.6667060852050781, 0.8332901000976562,
    0.6667060852050781, 0.8332939147949219, 0.6667060852050781, 0.8332939147949219,
    0.6667022705078125, 0.8332901000976562, 0.6667098999023438, 0.8332939147949219,
    0.6666984558105469, 0.8332862854003906, 0.6667098999023438, 0.8332977294921875,
    0.6666793823242188, 0.8332672119140625, 0.6667137145996094, 0.8332977294921875,
    0.6667518615722656, 0.8333358764648438, 0.6667137145996094, 0.8333015441894531,
    0.666656494140625, 0.8332405090332031, 0.666717529296875, 0.8333015441894531,
    0.6667633056640625, 0.8333511352539062, 0.666717529296875, 0.8333053588867188,
    0.6666488647460938, 0.8332328796386719, 0.6667213439941406, 0.8333053588867188,
    0.6667671203613281, 0.8333511352539062, 0.6667213439941406, 0.8333091735839844,
    0.6666450500488281, 0.8332328796386719, 0.6667251586914062, 0.8333091735839844,
    0.6667671203613281, 0.8333549499511719, 0.6667251586914062, 0.83331298828125,
    0.6666450500488281, 0.8332328796386719, 0.6667289733886719, 0.83331298828125,
    0.6670112609863281, 0.8335990905761719, 0.6667289733886719, 0.83331298828125,
    0.7679481506347656, 0.9345321655273438, 0.759307861328125, 0.9258918762207031,
    0.8688812255859375, 1.0354690551757812, 0.8518867492675781, 1.0184745788574219,
    0.969818115234375, 1.1364021301269531, 0.9444656372070312, 1.111053466796875,
    1.0707511901855469, 1.2373390197753906, 1.0370445251464844, 1.2036323547363281,
    1.1716880798339844, 1.3382720947265625, 1.1296234130859375, 1.2962112426757812,
    1.2726211547851562, 1.439208984375, 1.2222023010253906, 1.3887901306152344,
    1.3029861450195312, 1.469573974609375, 1.3147811889648438, 1.4813690185546875,
    1.3333549499511719, 1.49993896484375, 1.4073600769042969, 1.5739479064941406,
    1.3333549499511719, 1.49993896484375, 1.49993896484375, 1.6665267944335938,
    1.3333549499511719, 1.49993896484375, 1.5925178527832031, 1.7591056823730469,
    1.3333549499511719, 1.49993896484375, 1.6850967407226562, 1.8516845703125,
    1.3333549499511719, 1.49993896484375, 1.7776756286621094, 1.9442634582519531,
    1.3333549499511719, 1.49993896484375, 1.8702545166015625, 2.0368423461914062,
    1.3333549499511719, 1.49993896484375, 1.9628334045410156, 2.1294212341308594,
    1.3333549499511719, 1.49993896484375, 2.0554122924804688, 2.2220001220703125,
    1.3333549499511719, 1.49993896484375, 2.147991180419922, 2.3145790100097656,
    1.3333549499511719, 1.49993896484375, 2.240570068359375, 2.4071578979492188,
    1.3333549499511719, 1.49993896484375, 2.333148956298828, 2.499736785888672,
    1.3333549499511719, 1.49993896484375, 2.333393096923828, 2.499980926513672,
    1.3333549499511719, 1.49993896484375, 2.333393096923828, 2.499980926513672,
    1.3333549499511719, 1.49993896484375, 2.333393096923828, 2.499980926513672,
    1.3333549499511719, 1.49993896484375, 2.333393096923828, 2.499980926513672,
    1.3333549499511719, 1.49993896484375, 2.333393096923828, 2.499980926513672,
    1.3333549499511719, 1.49993896484375, 2.333393096923828, 2.499980926513672,
    1.3333549499511719, 1.49993896484375, 2.333393096923828, 2.499980926513672,
    1.3333549499511719, 1.49993896484375, 2.333393096923828, 2.499980926513672,
    1.3333549499511719, 1.49993896484375, 2.333393096923828, 2.499980926513672,
    1.3333549499511719, 1.49993896484375, 2.333393096923828, 2.499980926513672,
    1.3333549499511719, 1.49993896484375, 2.333393096923828, 2.499980926513672,
    1.3333549499511719, 1.49993896484375, 2.333393096923828, 2.499980926513672,
    1.3333549499511719, 1.49993896484375, 2.333393096923828, 2.499980926513672,
    1.3335990905761719, 1.50018310546875, 2.333148956298828, 2.499736785888672,
    1.389129638671875, 1.5557136535644531, 2.277618408203125, 2.4442062377929688,
    1.4446601867675781, 1.6112442016601562, 2.222087860107422, 2.3886756896972656,
    1.5001907348632812, 1.6667747497558594, 2.1665573120117188, 2.3331451416015625,
    1.5557212829589844, 1.7223052978515625, 2.1110267639160156, 2.2776145935058594,
    1.6112518310546875, 1.7778358459472656, 2.0554962158203125, 2.2220802307128906,
    1.6667823791503906, 1.8333663940429688, 1.9999656677246094, 2.1665496826171875,
    1.7223129272460938, 1.8888969421386719, 1.9444351196289062, 2.1110191345214844,
    1.7778434753417969, 1.944427490234375, 1.8889045715332031, 2.0554885864257812,
    1.8333740234375, 1.9999580383300781, 1.8333740234375, 1.9999580383300781,
    1.8889045715332031, 2.0554885864257812, 1.7778434753417969, 1.944427490234375,
    1.9444351196289062, 2.1110191345214844, 1.7223129272460938, 1.8888969421386719,
    1.9999656677246094, 2.1665496826171875, 1.6667823791503906, 1.8333663940429688,
    2.0554962158203125, 2.2220802307128906, 1.6112518310546875, 1.7778358459472656,
    2.1110267639160156, 2.2776145935058594, 1.5557212829589844, 1.7223052978515625,
    2.1665573120117188, 2.3331451416015625, 1.5001907348632812, 1.6667747497558594,
    2.222087860107422, 2.3886756896972656, 1.4446601867675781, 1.6112442016601562,
    2.277618408203125, 2.4442062377929688, 1.389129638671875, 1.5557136535644531,
    2.333148956298828, 2.499736785888672, 1.3335990905761719, 1.50018310546875,
    2.333393096923828, 2.499980926513672, 1.3333549499511719, 1.49993896484375,
    2.333393096923828, 2.499980926513672, 1.3333549499511719, 1.49993896484375,
    2.333393096923828, 2.499980926513672, 1.3333549499511719, 1.49993896484375,
    2.333393096923828, 2.499980926513672, 1.3333549499511719, 1.49993896484375,
    2.333393096923828, 2.499980926513672, 1.3333549499511719, 1.49993896484375,
    2.333393096923828, 2.499980926513672, 1.3333549499511719, 1.49993896484375,
    2.333393096923828, 2.499980926513672, 1.3333549499511719, 1.49993896484375,
    2.333393096923828, 2.499980926513672, 1.3333549499511719, 1.49993896484375,
    2.333393096923828, 2.499980926513672, 1.3333549499511719, 1.49993896484375,
    2.333393096923828, 2.499980926513672, 1.3333549499511719, 1.49993896484375,
    2.333393096923828, 2.499980926513672, 1.3333549499511719, 1.49993896484375,
    2.333393096923828, 2.499980926513672, 1.3333549499511719, 1.49993896484375,
    2.333393096923828, 2.499980926513672, 1.3333549499511719, 1.49993896484375,
    2.333148956298828, 2.499736785888672, 1.3335990905761719, 1.50018310546875,
    2.277618408203125, 2.4442062377929688, 1.3891410827636719, 1.55572509765625,
    2.222087860107422, 2.3886756896972656, 1.4446792602539062, 1.61126708984375,
    2.1665573120117188, 2.3331451416015625, 1.5002212524414062, 1.66680908203125,
    2.1110267639160156, 2.2776145935058594, 1.5557632446289062, 1.7223472595214844,
    2.0554962158203125, 2.2220802307128906, 1.6113052368164062, 1.7778892517089844,
    1.9999656677246094, 2.1665496826171875, 1.6668472290039062, 1.8334312438964844,
    1.9444351196289062, 2.1110191345214844, 1.7223892211914062, 1.8889732360839844,
    1.8889045715332031, 2.0554885864257812, 1.7779273986816406, 1.9445152282714844,
    1.8333740234375, 1.9999580383300781, 1.8334693908691406, 2.0000572204589844,
    1.7778434753417969, 1.944427490234375, 1.8890113830566406, 2.0555953979492188,
    1.7223129272460938, 1.8888969421386719, 1.9445533752441406, 2.1111373901367188,
    1.6667823791503906, 1.8333663940429688, 2.0000953674316406, 2.1666793823242188,
    1.6112518310546875, 1.7778358459472656, 2.0556373596191406, 2.2222213745117188,
    1.5557212829589844, 1.7223052978515625, 2.111175537109375, 2.2777633666992188,
    1.5001907348632812, 1.6667747497558594, 2.166717529296875, 2.3333053588867188,
    1.4446601867675781, 1.6112442016601562, 2.222259521484375, 2.388843536376953,
    1.389129638671875, 1.5557136535644531, 2.277801513671875, 2.444385528564453,
    1.3335990905761719, 1.50018310546875, 2.333343505859375, 2.499927520751953,
    1.3333549499511719, 1.49993896484375, 2.333354949951172, 2.49993896484375,
    1.3333549499511719, 1.49993896484375, 2.3333663940429688, 2.499950408935547,
    1.3333549499511719, 1.49993896484375, 2.3333740234375, 2.4999618530273438,
    1.3333549499511719, 1.49993896484375, 2.333385467529297, 2.4999732971191406,
    1.3333549499511719, 1.49993896484375, 2.3333969116210938, 2.4999847412109375,
    1.3333549499511719, 1.49993896484375, 2.333332061767578, 2.4999160766601562,
    1.3333549499511719, 1.49993896484375, 2.3334274291992188, 2.500011444091797,
    1.3333549499511719, 1.49993896484375, 2.3333168029785156, 2.4999046325683594,
    1.3333549499511719, 1.49993896484375, 2.3334312438964844, 2.500019073486328,
    1.3333549499511719, 1.49993896484375, 2.33331298828125, 2.4999008178710938,
    1.3333549499511719, 1.49993896484375, 2.33343505859375, 2.500019073486328,
    1.3333549499511719, 1.49993896484375, 2.33331298828125, 2.499897003173828,
    1.3333549499511719, 1.49993896484375, 2.33343505859375, 2.500019073486328,
    1.3335990905761719, 1.50018310546875, 2.33306884765625, 2.499652862548828,
    1.4335517883300781, 1.6001396179199219, 2.2331314086914062, 2.3997154235839844,
    1.53350830078125, 1.7000923156738281, 2.133190155029297, 2.2997779846191406,
    1.6334648132324219, 1.800048828125, 2.033252716064453, 2.1998367309570312,
    1.7334175109863281, 1.9000053405761719, 1.9333114624023438, 2.0998992919921875,
    1.8333740234375, 1.9999580383300781, 1.8333740234375, 1.9999580383300781,
    1.9333305358886719, 2.09991455078125, 1.7334365844726562, 1.9000205993652344,
    2.033283233642578, 2.199871063232422, 1.6334953308105469, 1.8000831604003906,
    2.13323974609375, 2.299823760986328, 1.5335578918457031, 1.7001419067382812,
    2.233196258544922, 2.3997802734375, 1.4336166381835938, 1.6002044677734375,
    2.333148956298828, 2.499736785888672, 1.33367919921875, 1.5002632141113281,
    2.333393096923828, 2.499980926513672, 1.33331298828125, 1.4998970031738281,
    2.333393096923828, 2.499980926513672, 1.33343505859375, 1.5000190734863281,
    2.333393096923828, 2.499980926513672, 1.33331298828125, 1.4998970031738281,
    2.333393096923828, 2.499980926513672, 1.33343505859375, 1.5000190734863281,
    2.333393096923828, 2.499980926513672, 1.3333168029785156, 1.4999008178710938,
    2.333393096923828, 2.499980926513672, 1.3334312438964844, 1.5000152587890625,
    2.333393096923828, 2.499980926513672, 1.3333206176757812, 1.4999046325683594,
    2.333393096923828, 2.499980926513672, 1.3334197998046875, 1.5000038146972656,
    2.333393096923828, 2.499980926513672, 1.333343505859375, 1.4999313354492188,
    2.333393096923828, 2.499980926513672, 1.3333740234375, 1.4999580383300781,
    2.333393096923828, 2.499980926513672, 1.3333702087402344, 1.4999580383300781,
    2.333393096923828, 2.499980926513672, 1.3333702087402344, 1.4999542236328125,
    2.333393096923828, 2.499980926513672, 1.3333702087402344, 1.4999542236328125,
    2.333393096923828, 2.499980926513672, 1.3333702087402344, 1.4999542236328125,
    2.333393096923828, 2.499980926513672, 1.3333663940429688, 1.4999542236328125,
    2.333393096923828, 2.499980926513672, 1.3333663940429688, 1.4999504089355469,
    2.333393096923828, 2.499980926513672, 1.3333663940429688, 1.4999504089355469,
    2.333393096923828, 2.499980926513672, 1.3333663940429688, 1.4999504089355469,
    2.333393096923828, 2.499980926513672, 1.3333625793457031, 1.4999504089355469,
    2.333393096923828, 2.499980926513672, 1.3333625793457031, 1.4999465942382812,
    2.333393096923828, 2.499980926513672, 1.3333625793457031, 1.4999465942382812,
    2.333393096923828, 2.499980926513672, 1.3333625793457031, 1.4999465942382812,
    2.333393096923828, 2.499980926513672, 1.3333587646484375, 1.4999465942382812,
    2.333393096923828, 2.499980926513672, 1.3333587646484375, 1.4999427795410156,
    2.333393096923828, 2.499980926513672, 1.3333587646484375, 1.4999427795410156,
    2.333393096923828, 2.499980926513672, 1.3333587646484375, 1.4999427795410156,
    2.333393096923828, 2.499980926513672, 1.3333549499511719, 1.4999427795410156,
    2.333393096923828, 2.499980926513672, 1.3333549499511719, 1.49993896484375,
    2.333393096923828, 2.499980926513672, 1.3333549499511719, 1.49993896484375,
    2.333393096923828, 2.499980926513672, 1.3333549499511719, 1.49993896484375,
    2.333148956298828, 2.499736785888672, 1.3335990905761719, 1.50018310546875,
    2.3317909240722656, 2.4983787536621094, 1.410888671875, 1.5774726867675781,
    2.330432891845703, 2.497020721435547, 1.4881744384765625, 1.6547622680664062,
    2.3290748596191406, 2.4956626892089844, 1.5654640197753906, 1.7320518493652344,
    2.327716827392578, 2.494304656982422, 1.6427536010742188, 1.8093376159667969,
    2.3263587951660156, 2.4929466247558594, 1.7200431823730469, 1.886627197265625,
    2.325000762939453, 2.491588592529297, 1.797332763671875, 1.9639167785644531,
    2.3236427307128906, 2.4902305603027344, 1.8746223449707031, 2.0412063598632812,
    2.322284698486328, 2.488872528076172, 1.9519081115722656, 2.1184959411621094,
    2.3209266662597656, 2.4875144958496094, 2.0291976928710938, 2.195781707763672,
    2.319568634033203, 2.486156463623047, 2.106487274169922, 2.2730712890625,
    2.3182106018066406, 2.4847984313964844, 2.18377685546875, 2.350360870361328,
    2.316852569580078, 2.483440399169922, 2.261066436767578, 2.4276504516601562,
    2.3154945373535156, 2.4820823669433594, 2.3383522033691406, 2.5049400329589844,
    2.3915328979492188, 2.558116912841797, 2.4156417846679688, 2.5822296142578125,
    2.4675674438476562, 2.6341514587402344, 2.492931365966797, 2.659515380859375,
    2.5436019897460938, 2.710186004638672, 2.570220947265625, 2.736804962158203,
    2.6196365356445312, 2.786224365234375, 2.647510528564453, 2.8140945434570312,
    2.6956748962402344, 2.8622589111328125, 2.7247962951660156, 2.8913841247558594,
    2.771709442138672, 2.93829345703125, 2.8020858764648438, 2.9686737060546875,
    2.8477439880371094, 3.014331817626953, 2.879375457763672, 3.04595947265625,
    2.9237823486328125, 3.0903663635253906, 2.9566650390625, 3.123249053955078,
    2.99981689453125, 3.166400909423828, 3.000011444091797, 3.1665992736816406,
    3.00006103515625, 3.166645050048828, 3.000019073486328, 3.166606903076172,
    3.00006103515625, 3.166645050048828, 3.0000267028808594, 3.166614532470703,
    3.00006103515625, 3.166645050048828, 3.0000381469726562, 3.1666221618652344,
    3.00006103515625, 3.166645050048828, 3.0000457763671875, 3.1666297912597656,
    3.00006103515625, 3.166645050048828, 3.0000534057617188, 3.166637420654297,
    3.00006103515625, 3.166645050048828, 3.00006103515625, 3.166645050048828,
    3.00006103515625, 3.166645050048828, 3.00006103515625, 3.166645050048828,
    3.00006103515625, 3.166645050048828, 3.00006103515625, 3.166645050048828,
    3.00006103515625, 3.166645050048828, 3.00006103515625, 3.166645050048828,
    3.00006103515625, 3.166645050048828, 3.00006103515625, 3.166645050048828,
    3.00006103515625, 3.166645050048828, 3.00006103515625, 3.166645050048828,
    3.00006103515625, 3.166645050048828, 3.00006103515625, 3.166645050048828,
    3.00006103515625, 3.166645050048828, 3.00006103515625, 3.166645050048828,
    3.00006103515625, 3.166645050048828, 3.00006103515625, 3.166645050048828,
    3.00006103515625, 3.166645050048828, 3.00006103515625, 3.166645050048828,
    3.00006103515625, 3.166645050048828, 3.00006103515625, 3.166645050048828,
    3.00006103515625, 3.166645050048828, 3.00006103515625, 3.166645050048828,
    3.00006103515625, 3.166645050048828, 3.00006103515625, 3.166645050048828,
    3.00006103515625, 3.166645050048828, 3.00006103515625, 3.166645050048828,
    3.00006103515625, 3.166645050048828, 3.00006103515625, 3.166645050048828,
    3.00006103515625, 3.166645050048828, 3.00006103515625, 3.166645050048828,
    3.00006103515625, 3.166645050048828, 3.00006103515625, 3.166645050048828
};

/* Covered starts have x strictly above these bounds, by component. */
static const waypoints_real waypoints_start_lower[2] = {
    4.005234146118169, 4.005237922668462
};

/* Covered starts have x strictly below these bounds, by component. */
static const waypoints_real waypoints_start_upper[2] = {
    4.994765853881831, 4.994762077331538
};

/* Spline time u = 192 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 192 (t_c = 18 s).
 */
static inline void waypoints_segment(waypoints_real t, int32_t *row, waypoints_real *s)
{
    const bool positive = 0.0 < t;
    const waypoints_real started = positive ? t : 0.0;
    const waypoints_real scaled = started * 10.666666666666666;
    const bool early = scaled < 191.99999999999997;
    const waypoints_real u = early ? scaled : 191.99999999999997;
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
    const waypoints_real v0 = 1.0 - s;
    const waypoints_real v1 = v0 * v0;
    const waypoints_real v2 = v1 * v0;
    const waypoints_real v3 = v0 * s;
    const waypoints_real v4 = 1.0 + v3;
    const waypoints_real v5 = 3.0 * v4;
    const waypoints_real v6 = v0 * v5;
    const waypoints_real v7 = 1.0 + v6;
    const waypoints_real v8 = s * v5;
    const waypoints_real v9 = 1.0 + v8;
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
    const waypoints_real v0 = 1.0 - s;
    const waypoints_real v1 = v0 + v0;
    const waypoints_real v2 = v0 * v1;
    const waypoints_real v3 = v0 * v0;
    const waypoints_real v4 = v2 + v3;
    const waypoints_real v5 = -v4;
    const waypoints_real v6 = v0 - s;
    const waypoints_real v7 = 3.0 * v6;
    const waypoints_real v8 = v0 * v7;
    const waypoints_real v9 = v0 * s;
    const waypoints_real v10 = 1.0 + v9;
    const waypoints_real v11 = 3.0 * v10;
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
    const waypoints_real v1 = log(v0);
    const waypoints_real v2 = -v1;
    const waypoints_real v3 = 1.0 + v0;
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
    const bool moving = t < 18.0;
    const waypoints_real per_second = moving ? 10.666666666666666 : 0.0;
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
    const waypoints_real t_zero = t * 0.0;
    waypoints_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const waypoints_real x_j = x[j];
        const waypoints_real x_zero = x_j * 0.0;
        const waypoints_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 2; ++m) {
            u[m] = 0.0;
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
        const waypoints_real gain = upper_nearer ? (-0.5) : 0.5;
        const waypoints_real smallest = width * 0.005;
        const bool clear = smallest < distance;
        const waypoints_real to_nearer = clear ? distance : smallest;
        const waypoints_real to_farther = width - to_nearer;
        const bool inside = 0.0 < distance;
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
    const waypoints_real t_zero = t * 0.0;
    waypoints_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const waypoints_real x_j = x[j];
        const waypoints_real x_zero = x_j * 0.0;
        const waypoints_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0;
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
    waypoints_real margin = 0.5;
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
        const bool x_beyond = x_share < (-1.0);
        const waypoints_real margin_x = x_beyond ? (-1.0) : x_share;
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
        const bool x_beyond = x_share < (-1.0);
        const waypoints_real margin_x = x_beyond ? (-1.0) : x_share;
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
        const bool filled = 0.0 < width;
        const bool empty = !filled;
        const bool wide = 9.5367431640625e-7 < width;
        const waypoints_real safe_width = wide ? width : 9.5367431640625e-7;
        const waypoints_real to_lower = x_i - lower_edge;
        const waypoints_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const waypoints_real distance = upper_nearer ? to_upper : to_lower;
        const waypoints_real sign = upper_nearer ? (-1.0) : 1.0;
        const waypoints_real smallest = safe_width * 0.005;
        const waypoints_real widened = safe_width - width;
        const waypoints_real half = widened * 0.5;
        const waypoints_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const waypoints_real to_nearer = clear ? safe_distance : smallest;
        const waypoints_real to_farther = safe_width - to_nearer;
        const waypoints_real a = upper_nearer ? to_farther : to_nearer;
        const waypoints_real b = upper_nearer ? to_nearer : to_farther;
        const waypoints_real e_i = waypoints_normalized_error(a, b, safe_width);
        const bool e_above = (-0.99) < e_i;
        const waypoints_real e_raised = e_above ? e_i : (-0.99);
        const bool e_beyond = 0.99 < e_raised;
        const waypoints_real e_limited = e_beyond ? 0.99 : e_raised;
        waypoints_real epsilon_nearer;
        waypoints_real xi_i;
        waypoints_transformed_error(to_nearer, to_farther, &epsilon_nearer, &xi_i);
        const waypoints_real epsilon_i = sign * epsilon_nearer;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_width = isfinite(width) != 0;
        const bool finite = finite_x && finite_width;
        const waypoints_real e_or_zero = empty ? 0.0 : e_limited;
        const waypoints_real e_out = finite ? e_or_zero : (waypoints_real)NAN;
        e[i] = e_out;
        const waypoints_real epsilon_or_zero = empty ? 0.0 : epsilon_i;
        const waypoints_real epsilon_out = finite ? epsilon_or_zero : (waypoints_real)NAN;
        epsilon[i] = epsilon_out;
        const waypoints_real xi_or_zero = empty ? 0.0 : xi_i;
        const waypoints_real xi_out = finite ? xi_or_zero : (waypoints_real)NAN;
        xi[i] = xi_out;
    }
}
