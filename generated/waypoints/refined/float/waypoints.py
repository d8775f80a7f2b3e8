"""waypoints: prescribed-time reach-avoid-stay controller, refined tube.

Certified (waypoints.certificate.json): for every t the tube keeps 0.03 from every
unsafe set, stays in the state space, is at least 0.05 wide, and carries out the mission.
Every x(t) that stays in the tube satisfies the mission (P10): (always[0, 1] home and always[3, 4] left and
always[6, 7] right and always[9, 10] left and always[12, 13] right and always[17, 18] goal); times are seconds of
t. It still holds where every time at which the tube is in a region, or off one, is wrong by up to 0.0312 s.

The same functions as waypoints.c (single precision there) in double arithmetic on the same constants.
Arrays come in as sequences of 2 numbers and go out as tuples.
Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
"""

import math

N = 2
T_C = 18.0  # prescribed time, seconds
SHARE = 0.9899999499320984  # 0.99, rounded down, of the tube's half widths at t = 0: the starts of `covered`
DESIGN_HASH = "27bf76fd458edffa"

OK = 0
OUTSIDE_TUBE = 1
BAD_INPUT = 2

# B-spline control points divided by 6, one row for each of 192 + 3 points:
# lower[0], upper[0], lower[1], upper[1]
# Multiples of 2^-18: exact in float and double.
COEFFICIENTS = (
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
    3.00006103515625, 3.166645050048828, 3.00006103515625, 3.166645050048828,
)

# Covered starts have x strictly above these bounds, by component.
START_LOWER = (
    4.005236625671387, 4.005240440368652,
)

# Covered starts have x strictly below these bounds, by component.
START_UPPER = (
    4.994763374328613, 4.994759559631348,
)


def _vector(name, values, length):
    """The values as floats; ValueError when there are not `length` of them."""
    numbers = [float(v) for v in values]
    if len(numbers) != length:
        raise ValueError(f"{name} has {len(numbers)} entries, {length} are needed")
    return numbers


def _segment(t):
    """Spline time u = 192 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
    Before 0 the start; from t_c on the last number below 192 (t_c = 18 s).
    """
    positive = 0.0 < t
    started = t if positive else 0.0
    scaled = started * 10.666666984558105
    early = scaled < 191.99998474121094
    u = scaled if early else 191.99998474121094
    segment = int(u)
    base = float(segment)
    place = u - base
    first = segment * 4
    return first, place


def _basis(s):
    """6 times the uniform cubic B-spline basis at s in [0, 1]: weights >= 0 with sum 6."""
    v0 = 1.0 - s
    v1 = v0 * v0
    v2 = v1 * v0
    v3 = v0 * s
    v4 = 1.0 + v3
    v5 = 3.0 * v4
    v6 = v0 * v5
    v7 = 1.0 + v6
    v8 = s * v5
    v9 = 1.0 + v8
    v10 = s * s
    v11 = v10 * s
    return v2, v7, v9, v11


def _basis_rate(s):
    """Derivative of the weights with respect to s."""
    v0 = 1.0 - s
    v1 = v0 + v0
    v2 = v0 * v1
    v3 = v0 * v0
    v4 = v2 + v3
    v5 = -v4
    v6 = v0 - s
    v7 = 3.0 * v6
    v8 = v0 * v7
    v9 = v0 * s
    v10 = 1.0 + v9
    v11 = 3.0 * v10
    v12 = v8 - v11
    v13 = s * v7
    v14 = v11 + v13
    v15 = s + s
    v16 = s * v15
    v17 = s * s
    v18 = v16 + v17
    return v5, v12, v14, v18


def _blend(w0, w1, w2, w3, q0, q1, q2, q3):
    """An edge of the tube (or its slope in spline time): sum of w_j q_j."""
    v0 = w0 * q0
    v1 = w1 * q1
    v2 = v0 + v1
    v3 = w2 * q2
    v4 = w3 * q3
    v5 = v3 + v4
    v6 = v2 + v5
    return v6


def _normalized_error(a, b, width):
    """Normalized error e = (2 x - gamma_s) / gamma_d, from a = x - lower, b = upper - x."""
    v0 = a - b
    v1 = v0 / width
    return v1


def _transformed_error(a, b):
    """Transformed error epsilon = ln((1 + e)/(1 - e)) = ln(a/b) and xi = d epsilon/dx = 1/a + 1/b."""
    v0 = b / a
    v1 = math.log(v0)
    v2 = -v1
    v3 = 1.0 + v0
    v4 = v3 / b
    return v2, v4


def _law(k, xi, epsilon):
    """Control law (13): u = -k xi epsilon."""
    v0 = k * xi
    v1 = v0 * epsilon
    v2 = -v1
    return v2


def tube(t):
    """Edges of the tube gamma at time t (seconds), in the task's units.
    t below 0 counts as 0 and above t_c as t_c; NaN when t is not finite.
    """
    t = float(t)
    lower = [0.0] * 2
    upper = [0.0] * 2
    finite = math.isfinite(t)
    bad = not finite
    if bad:
        for j in range(2):
            lower[j] = math.nan
            upper[j] = math.nan
        return tuple(lower), tuple(upper)
    row, s = _segment(t)
    w0, w1, w2, w3 = _basis(s)
    for i in range(2):
        pair = i * 2
        at = row + pair
        lower_q0 = COEFFICIENTS[at]
        lower_1 = at + 4
        lower_q1 = COEFFICIENTS[lower_1]
        lower_2 = at + 8
        lower_q2 = COEFFICIENTS[lower_2]
        lower_3 = at + 12
        lower_q3 = COEFFICIENTS[lower_3]
        lower_edge = _blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3)
        lower[i] = lower_edge
        upper_0 = at + 1
        upper_q0 = COEFFICIENTS[upper_0]
        upper_1 = at + 5
        upper_q1 = COEFFICIENTS[upper_1]
        upper_2 = at + 9
        upper_q2 = COEFFICIENTS[upper_2]
        upper_3 = at + 13
        upper_q3 = COEFFICIENTS[upper_3]
        upper_edge = _blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3)
        upper[i] = upper_edge
    return tuple(lower), tuple(upper)


def tube_rate(t):
    """Rate of change of the edges, d gamma / d t, at time t (seconds), in units per second.
    The rate at 0 before that and zero from t_c on; NaN when t is not finite.
    """
    t = float(t)
    lower_rate = [0.0] * 2
    upper_rate = [0.0] * 2
    finite = math.isfinite(t)
    bad = not finite
    if bad:
        for j in range(2):
            lower_rate[j] = math.nan
            upper_rate[j] = math.nan
        return tuple(lower_rate), tuple(upper_rate)
    row, s = _segment(t)
    dw0, dw1, dw2, dw3 = _basis_rate(s)
    moving = t < 18.0
    per_second = 10.666666984558105 if moving else 0.0
    for i in range(2):
        pair = i * 2
        at = row + pair
        lower_q0 = COEFFICIENTS[at]
        lower_1 = at + 4
        lower_q1 = COEFFICIENTS[lower_1]
        lower_2 = at + 8
        lower_q2 = COEFFICIENTS[lower_2]
        lower_3 = at + 12
        lower_q3 = COEFFICIENTS[lower_3]
        lower_slope = _blend(dw0, dw1, dw2, dw3, lower_q0, lower_q1, lower_q2, lower_q3)
        lower_speed = lower_slope * per_second
        lower_rate[i] = lower_speed
        upper_0 = at + 1
        upper_q0 = COEFFICIENTS[upper_0]
        upper_1 = at + 5
        upper_q1 = COEFFICIENTS[upper_1]
        upper_2 = at + 9
        upper_q2 = COEFFICIENTS[upper_2]
        upper_3 = at + 13
        upper_q3 = COEFFICIENTS[upper_3]
        upper_slope = _blend(dw0, dw1, dw2, dw3, upper_q0, upper_q1, upper_q2, upper_q3)
        upper_speed = upper_slope * per_second
        upper_rate[i] = upper_speed
    return tuple(lower_rate), tuple(upper_rate)


def control(t, x):
    """Control law (13), u = -k xi epsilon, k = 0.5, e clamped to [-0.99, 0.99] by component.
    t: seconds since the start (held within [0, t_c]); x: state; u: input.
    OK: x strictly inside the tube. OUTSIDE_TUBE: not so; u is the clamped law, finite, and points inward
    (0 where the tube is empty). BAD_INPUT: t or x has a NaN or an infinity; u is 0. u may be the array x itself.
    """
    t = float(t)
    x = _vector("x", x, 2)
    u = [0.0] * 2
    t_zero = t * 0.0
    zero = t_zero
    for j in range(2):
        x_j = x[j]
        x_zero = x_j * 0.0
        zeros = zero + x_zero
        zero = zeros
    finite = zero <= 0.0
    bad = not finite
    if bad:
        for j2 in range(2):
            u[j2] = 0.0
        return BAD_INPUT, tuple(u)
    row, s = _segment(t)
    w0, w1, w2, w3 = _basis(s)
    outside = False
    for i in range(2):
        pair = i * 2
        at = row + pair
        lower_q0 = COEFFICIENTS[at]
        lower_1 = at + 4
        lower_q1 = COEFFICIENTS[lower_1]
        lower_2 = at + 8
        lower_q2 = COEFFICIENTS[lower_2]
        lower_3 = at + 12
        lower_q3 = COEFFICIENTS[lower_3]
        lower_edge = _blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3)
        upper_0 = at + 1
        upper_q0 = COEFFICIENTS[upper_0]
        upper_1 = at + 5
        upper_q1 = COEFFICIENTS[upper_1]
        upper_2 = at + 9
        upper_q2 = COEFFICIENTS[upper_2]
        upper_3 = at + 13
        upper_q3 = COEFFICIENTS[upper_3]
        upper_edge = _blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3)
        x_i = x[i]
        room = upper_edge - lower_edge
        to_lower = x_i - lower_edge
        to_upper = upper_edge - x_i
        upper_nearer = to_upper < to_lower
        nearest = to_upper if upper_nearer else to_lower
        gain = -0.5 if upper_nearer else 0.5
        least = room * 0.004999999888241291
        clear = least < nearest
        near = nearest if clear else least
        far = room - near
        within = 0.0 < nearest
        outside_any = outside if within else True
        epsilon, xi = _transformed_error(near, far)
        push = _law(gain, xi, epsilon)
        u[i] = push
        outside = outside_any
    return OUTSIDE_TUBE if outside else OK, tuple(u)


def margin(t, x):
    """How far x is from leaving the tube: the distance to the nearest edge over the tube's width there, least over the
    components. 0.5 in the middle, positive inside, negative outside, at least -1; NaN when an argument is not finite.
    Watch it: act while there is margin, not when the tube is left.
    """
    t = float(t)
    x = _vector("x", x, 2)
    t_zero = t * 0.0
    zero = t_zero
    for j in range(2):
        x_j = x[j]
        x_zero = x_j * 0.0
        zeros = zero + x_zero
        zero = zeros
    finite = zero <= 0.0
    bad = not finite
    if bad:
        return math.nan
    row, s = _segment(t)
    w0, w1, w2, w3 = _basis(s)
    margin = 0.5
    for i in range(2):
        pair = i * 2
        at = row + pair
        lower_q0 = COEFFICIENTS[at]
        lower_1 = at + 4
        lower_q1 = COEFFICIENTS[lower_1]
        lower_2 = at + 8
        lower_q2 = COEFFICIENTS[lower_2]
        lower_3 = at + 12
        lower_q3 = COEFFICIENTS[lower_3]
        lower_edge = _blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3)
        upper_0 = at + 1
        upper_q0 = COEFFICIENTS[upper_0]
        upper_1 = at + 5
        upper_q1 = COEFFICIENTS[upper_1]
        upper_2 = at + 9
        upper_q2 = COEFFICIENTS[upper_2]
        upper_3 = at + 13
        upper_q3 = COEFFICIENTS[upper_3]
        upper_edge = _blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3)
        x_i = x[i]
        room = upper_edge - lower_edge
        to_lower = x_i - lower_edge
        to_upper = upper_edge - x_i
        upper_nearer = to_upper < to_lower
        nearest = to_upper if upper_nearer else to_lower
        share = nearest / room
        beyond = share < -1.0
        held_share = -1.0 if beyond else share
        less = held_share < margin
        margin_next = held_share if less else margin
        margin = margin_next
    return margin


def margins(t, x):
    """The margin of each component: which axis is near its edge. NaN where that component of the state is NaN; in all
    components where another argument is not finite.
    """
    t = float(t)
    x = _vector("x", x, 2)
    margin = [0.0] * 2
    finite = math.isfinite(t)
    bad = not finite
    if bad:
        for j in range(2):
            margin[j] = math.nan
        return tuple(margin)
    row, s = _segment(t)
    w0, w1, w2, w3 = _basis(s)
    for i in range(2):
        pair = i * 2
        at = row + pair
        lower_q0 = COEFFICIENTS[at]
        lower_1 = at + 4
        lower_q1 = COEFFICIENTS[lower_1]
        lower_2 = at + 8
        lower_q2 = COEFFICIENTS[lower_2]
        lower_3 = at + 12
        lower_q3 = COEFFICIENTS[lower_3]
        lower_edge = _blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3)
        upper_0 = at + 1
        upper_q0 = COEFFICIENTS[upper_0]
        upper_1 = at + 5
        upper_q1 = COEFFICIENTS[upper_1]
        upper_2 = at + 9
        upper_q2 = COEFFICIENTS[upper_2]
        upper_3 = at + 13
        upper_q3 = COEFFICIENTS[upper_3]
        upper_edge = _blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3)
        x_i = x[i]
        room = upper_edge - lower_edge
        to_lower = x_i - lower_edge
        to_upper = upper_edge - x_i
        upper_nearer = to_upper < to_lower
        nearest = to_upper if upper_nearer else to_lower
        share = nearest / room
        beyond = share < -1.0
        held_share = -1.0 if beyond else share
        margin[i] = held_share
    return tuple(margin)


def covered(x):
    """Whether the paper's Theorem 4.1, in continuous time, covers a start at the measured x:
    every component of x is within 0.99 of the tube's half width about its middle at t = 0.
    What a measurement may be wrong by (rounding) is taken off.
    Ask before the first step. Where it says false, nothing is proved of this start: move the robot, or design a tube
    from where it stands. False for a NaN.
    """
    x = _vector("x", x, 2)
    covered = True
    for i in range(2):
        x_i = x[i]
        start_lower_i = START_LOWER[i]
        start_upper_i = START_UPPER[i]
        x_i_after = start_lower_i < x_i
        x_i_before = x_i < start_upper_i
        x_i_between = x_i_after and x_i_before
        covered_next = covered if x_i_between else False
        covered = covered_next
    return covered


def transform(lower, upper, x):
    """Error transform of section IV for the state x in the box (lower, upper), by component:
      e       = (2 x - (upper + lower)) / (upper - lower), clamped to [-e_max, e_max]
      epsilon = ln((1 + e) / (1 - e))
      xi      = 4 / ((upper - lower) (1 - e^2)) = d epsilon / dx
    0 in a component with upper <= lower; a width below 2^-20 counts as that.
    NaN where an edge, x or upper - lower is not finite.
    """
    lower = _vector("lower", lower, 2)
    upper = _vector("upper", upper, 2)
    x = _vector("x", x, 2)
    e = [0.0] * 2
    epsilon = [0.0] * 2
    xi = [0.0] * 2
    for i in range(2):
        lower_edge = lower[i]
        upper_edge = upper[i]
        x_i = x[i]
        room = upper_edge - lower_edge
        filled = 0.0 < room
        empty = not filled
        wide = 9.5367431640625e-7 < room
        width = room if wide else 9.5367431640625e-7
        to_lower = x_i - lower_edge
        to_upper = upper_edge - x_i
        upper_nearer = to_upper < to_lower
        nearest = to_upper if upper_nearer else to_lower
        gain = -1.0 if upper_nearer else 1.0
        least = width * 0.004999999888241291
        widened = width - room
        spare = widened * 0.5
        distance = nearest + spare
        farther = least < distance
        clear = filled and farther
        near = distance if clear else least
        far = width - near
        a = far if upper_nearer else near
        b = near if upper_nearer else far
        e_raw = _normalized_error(a, b, width)
        e_held_above = -0.9900000095367432 < e_raw
        e_held_raised = e_raw if e_held_above else -0.9900000095367432
        e_held_over = 0.9900000095367432 < e_held_raised
        e_held = 0.9900000095367432 if e_held_over else e_held_raised
        epsilon_near, xi_i = _transformed_error(near, far)
        epsilon_i = gain * epsilon_near
        finite_x = math.isfinite(x_i)
        finite_room = math.isfinite(room)
        finite = finite_x and finite_room
        e_settled = 0.0 if empty else e_held
        e_out = e_settled if finite else math.nan
        e[i] = e_out
        epsilon_settled = 0.0 if empty else epsilon_i
        epsilon_out = epsilon_settled if finite else math.nan
        epsilon[i] = epsilon_out
        xi_settled = 0.0 if empty else xi_i
        xi_out = xi_settled if finite else math.nan
        xi[i] = xi_out
    return tuple(e), tuple(epsilon), tuple(xi)


def phase(t):
    """The entry of the mission that is being served at time t, from 1; 0 once all are done. See waypoints.h."""
    if t < 7.03125:
        return 1
    if t < 18.0:
        return 2
    return 0
