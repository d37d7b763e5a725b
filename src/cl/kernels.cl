/* SPDX-License-Identifier: MIT
 * Kernels of the dense path.  src/NUMERICS.md defines every number; integers only. */

#define SLOPE_NONE     INT32_MIN
#define FLAG_TEXTURE   1
#define FLAG_OCCLUDED  4
#define FLAG_EDGE      8
#define FLAG_RANGE_END 32
#define FLAG_UNIQUE    64
#define NONE_SEEN      65536u

/* ---- raw frame ---------------------------------------------------------------- */

static uint32_t lsb_stream(__global const uchar *p, ulong bit, uint32_t bits)
{
    __global const uchar *q = p + bit / 8;
    uint32_t low = (uint32_t)(bit % 8);
    uint32_t v = q[0] | (uint32_t)q[1] << 8;

    if (low + bits > 16) {
        v |= (uint32_t)q[2] << 16;
    }
    return v >> low & ((1u << bits) - 1u);
}

/* Pixel q of the frame's bit stream; formats in the order of plfx_raw_format. */
static uint32_t pixel(__global const uchar *p, int32_t format, ulong q)
{
    __global const uchar *pair = p + q / 2 * 3;
    __global const uchar *four = p + q / 4 * 5;
    uint32_t odd = (uint32_t)(q % 2);
    uint32_t k = (uint32_t)(q % 4);

    switch (format) {
    case 0:
        return p[q];
    case 1:
        return p[2 * q] | (uint32_t)p[2 * q + 1] << 8;
    case 2:
        return ((__global const ushort *)p)[q];
    case 3:
        return lsb_stream(p, 10 * q, 10);
    case 4:
        return lsb_stream(p, 12 * q, 12);
    case 5:
        return odd ? (uint32_t)pair[2] << 2 | (pair[1] >> 4 & 3)
                   : (uint32_t)pair[0] << 2 | (pair[1] & 3);
    case 6:
        return odd ? (uint32_t)pair[2] << 4 | pair[1] >> 4
                   : (uint32_t)pair[0] << 4 | (pair[1] & 15);
    case 7:
        return (uint32_t)four[k] << 2 | (four[4] >> 2 * k & 3);
    default:
        return (uint32_t)pair[odd] << 4 | (pair[2] >> 4 * odd & 15);
    }
}

/* Global size (w, h). */
__kernel void unpack(__constant int32_t *P, __global const uchar *raw,
                     __global ushort *frame)
{
    int32_t x = (int32_t)get_global_id(0);
    int32_t y = (int32_t)get_global_id(1);
    ulong q;

    if (x >= P[CL_RAW_W] || y >= P[CL_RAW_H]) {
        return;
    }
    q = (ulong)y * (ulong)P[CL_RAW_W] + (ulong)x;
    frame[q] = (ushort)(pixel(raw, P[CL_FORMAT], q) & ((1u << P[CL_RAW_BITS]) - 1u));
}

static uint32_t along_row(__constant int32_t *P, __global const ushort *frame,
                          int32_t x_q8, int32_t y)
{
    int32_t x = plfx_asr_i32(x_q8, 8);
    uint32_t f = (uint32_t)(x_q8 - 256 * x);
    __global const ushort *row = frame + (size_t)y * (size_t)P[CL_RAW_W];
    uint32_t p0 = row[plfx_clamp_i32(x, 0, P[CL_RAW_W] - 1)];
    uint32_t p1 = row[plfx_clamp_i32(x + 1, 0, P[CL_RAW_W] - 1)];
    int32_t k = P[CL_RAW_BITS] - 8;

    return (p0 * (256u - f) + p1 * f + ((1u << k) >> 1)) >> k;
}

static uint32_t sample_raw(__constant int32_t *P, __global const ushort *frame, int2 at)
{
    int32_t x_q8 = plfx_asr_i32(at.x + 128, 8);
    int32_t y_q8 = plfx_asr_i32(at.y + 128, 8);
    int32_t y = plfx_asr_i32(y_q8, 8);
    uint32_t f = (uint32_t)(y_q8 - 256 * y);
    int32_t last = P[CL_RAW_H] - 1;
    uint32_t h0 = along_row(P, frame, x_q8, plfx_clamp_i32(y, 0, last));
    uint32_t h1 = along_row(P, frame, x_q8, plfx_clamp_i32(y + 1, 0, last));

    return (h0 * (256u - f) + h1 * f + 128u) >> 8;
}

static ushort toned(__constant int32_t *P, uint32_t v, uint32_t gain)
{
    uint32_t top = (1u << P[CL_BITS]) - 1u;
    uint32_t lit = v > (uint32_t)P[CL_BLACK] ? v - (uint32_t)P[CL_BLACK] : 0u;
    uint32_t even = (lit * gain + 4096u) >> 13;
    uint64_t out =
        ((uint64_t)even * (uint64_t)P[CL_GAIN] + ((uint64_t)1 << (P[CL_DOWN] - 1))) >>
        P[CL_DOWN];

    return (ushort)(v >= (uint32_t)P[CL_CLIPPED] || out > top ? top : (uint32_t)out);
}

static uint32_t lens_sample(__constant int32_t *P, __global const ushort *frame,
                            __global const int2 *centre, int2 offset,
                            __global const ushort *gain, size_t lens, size_t at)
{
    uint32_t g = P[CL_WHITE] ? gain[at] : 8192u;

    return toned(P, sample_raw(P, frame, centre[lens] + offset), g);
}

/* Nearest lens with light from i on in a direction; -1 or nx when there is none. */
static int32_t lit(__constant int32_t *P, __global const uchar *missing, int32_t i,
                   int32_t direction)
{
    for (i += direction; i >= 0 && i < P[CL_NX] && missing[i]; i += direction) {
    }
    return i;
}

/* Global size (nx, ny, views).  centre q16, offset of each view q16; missing[lens] set:
 * no light, mean of the nearest lit lenses of the row. */
__kernel void extract(__constant int32_t *P, __global const ushort *frame,
                      __global const int2 *centre, __global const int2 *offset,
                      __global const uchar *missing, __global const ushort *gain,
                      __global ushort *views)
{
    int32_t i = (int32_t)get_global_id(0);
    int32_t j = (int32_t)get_global_id(1);
    int32_t k = (int32_t)get_global_id(2);
    size_t row = (size_t)j * (size_t)P[CL_NX];
    size_t out = ((size_t)j * (size_t)P[CL_VIEWS] + (size_t)k) * (size_t)P[CL_NX];
    uint32_t sum = 0;
    uint32_t count = 0;
    int32_t n;

    if (i >= P[CL_NX] || j >= P[CL_NY]) {
        return;
    }
    for (n = -1; n <= 1; n += 2) { /* left and right; the lens itself when it is lit */
        int32_t from = missing[row + (size_t)i] ? lit(P, missing + row, i, n) : i;
        if (from >= 0 && from < P[CL_NX]) {
            sum += lens_sample(P, frame, centre, offset[k], gain, row + (size_t)from,
                               out + (size_t)from);
            count++;
        }
    }
    views[out + (size_t)i] = (ushort)(count == 2 ? (sum + 1u) >> 1 : sum);
}

/* ---- views at a label --------------------------------------------------------- */

static uint32_t view_px(__constant int32_t *P, __global const ushort *views, int32_t k,
                        int32_t x, int32_t row)
{
    return views[((size_t)row * (size_t)P[CL_VIEWS] + (size_t)k) * (size_t)P[CL_NX] +
                 (size_t)plfx_clamp_i32(x, 0, P[CL_NX] - 1)];
}

static uint32_t tap(__constant int32_t *P, __global const ushort *views, int32_t k,
                    int32_t x_q4, int32_t x, int32_t y, int32_t row)
{
    int32_t r = plfx_clamp_i32(row, 0, P[CL_NY] - 1);
    int32_t q = x_q4 + (P[CL_HEX] ? P[CL_ODD] * ((y & 1) - (r & 1)) : 0);
    int32_t whole = plfx_asr_i32(q, 4);
    uint32_t f = (uint32_t)(q - 16 * whole);

    return view_px(P, views, k, x + whole, r) * (16u - f) +
           view_px(P, views, k, x + whole + 1, r) * f;
}

/* shift: sixteenths of a column and a row. */
static uint32_t sample_view(__constant int32_t *P, __global const ushort *views,
                            int32_t k, int2 shift, int32_t x, int32_t y)
{
    int32_t ky = plfx_asr_i32(shift.y, 4);
    uint32_t fy = (uint32_t)(shift.y - 16 * ky);
    uint32_t a = tap(P, views, k, shift.x, x, y, y + ky);
    uint32_t b = fy ? tap(P, views, k, shift.x, x, y, y + ky + 1) : 0u;

    return (a * (16u - fy) + b * fy + 128u) >> 8;
}

static int32_t pair_view(__constant int32_t *P, int32_t p)
{
    return p < P[CL_REF] ? p : p + 1;
}

static size_t cell(__constant int32_t *P, int32_t l, int32_t y, int32_t x)
{
    return ((size_t)l * (size_t)P[CL_NY] + (size_t)y) * (size_t)P[CL_NX] + (size_t)x;
}

/* ---- sum of absolute differences ---------------------------------------------- */

/* Global size (stride, ny, views): rows with replicated borders, so that no sample of
 * any label leaves them. */
__kernel void pad(__constant int32_t *P, __global const ushort *views,
                  __global ushort *padded)
{
    int32_t x = (int32_t)get_global_id(0);
    int32_t y = (int32_t)get_global_id(1);
    int32_t k = (int32_t)get_global_id(2);

    if (x < P[CL_STRIDE] && y < P[CL_NY]) {
        padded[(y * P[CL_VIEWS] + k) * P[CL_STRIDE] + x] =
            (ushort)view_px(P, views, k, x - P[CL_PAD], y);
    }
}

/* Where target (0,y) reads a padded row of view k displaced by x_q4. */
static int32_t entry(__constant int32_t *P, int32_t k, int32_t x_q4, int32_t y,
                     int32_t row, uint32_t *f)
{
    int32_t r = plfx_clamp_i32(row, 0, P[CL_NY] - 1);
    int32_t q = x_q4 + (P[CL_HEX] ? P[CL_ODD] * ((y & 1) - (r & 1)) : 0);
    int32_t whole = plfx_asr_i32(q, 4);

    *f = (uint32_t)(q - 16 * whole);
    return (r * P[CL_VIEWS] + k) * P[CL_STRIDE] + P[CL_PAD] + whole;
}

static uint8 along8(__global const ushort *p, uint32_t f)
{
    return convert_uint8(vload8(0, p)) * (16u - f) +
           convert_uint8(vload8(0, p + 1)) * f;
}

/* Element of a plane of costs at label l, row y, lens x. */
static size_t wide(__constant int32_t *P, int32_t l, int32_t y, int32_t x)
{
    return ((size_t)l * (size_t)P[CL_NY] + (size_t)y) * (size_t)P[CL_WIDE] + (size_t)x;
}

/* Global size (nx/8, ny, labels): |A - B| of view k for 8 lenses, added to what earlier
 * views left (first != 0: nothing); cut by shift1 after the last.  Lenses beyond nx
 * read the border and are not used. */
__kernel void sad_items(__constant int32_t *P, __global const ushort *padded,
                        __global const int2 *shift, int32_t k, int32_t first,
                        int32_t cut, __global ushort *item)
{
    int32_t x = 8 * (int32_t)get_global_id(0);
    int32_t y = (int32_t)get_global_id(1);
    int32_t l = (int32_t)get_global_id(2);
    int2 s = shift[k * P[CL_LABELS] + l];
    int32_t ky = plfx_asr_i32(s.y, 4);
    uint32_t fy = (uint32_t)(s.y - 16 * ky);
    uint32_t f;
    uint8 b;
    uint8 sum;
    int32_t at;

    if (x >= P[CL_NX] || y >= P[CL_NY]) {
        return;
    }
    at = entry(P, k, s.x, y, y + ky, &f) + x;
    b = along8(padded + at, f) * (16u - fy);
    if (fy) {
        at = entry(P, k, s.x, y, y + ky + 1, &f) + x;
        b += along8(padded + at, f) * fy;
    }
    b = (b + 128u) >> 8;
    at = (y * P[CL_VIEWS] + P[CL_REF]) * P[CL_STRIDE] + P[CL_PAD] + x;
    sum = abs_diff(convert_uint8(vload8(0, padded + at)), b);
    if (!first) {
        sum += convert_uint8(vload8(0, item + wide(P, l, y, x)));
    }
    vstore8(convert_ushort8(sum >> (uint32_t)cut), 0, item + wide(P, l, y, x));
}

/* Global size (nx/8, labels, bands): vertical sums of rows y-r..y+r, cut by shift2. */
__kernel void sad_columns(__constant int32_t *P, __global const ushort *item,
                          __global ushort *column)
{
    int32_t x = 8 * (int32_t)get_global_id(0);
    int32_t l = (int32_t)get_global_id(1);
    int32_t r = P[CL_WINDOW] / 2;
    int32_t first = r + (int32_t)get_global_id(2) * P[CL_BAND];
    int32_t end = plfx_min_i32(first + P[CL_BAND], P[CL_NY] - r);
    uint8 sum = 0;
    int32_t y;

    if (x >= P[CL_NX] || first >= end || l >= P[CL_LABELS]) {
        return;
    }
    for (y = first - r; y < first + r; y++) {
        sum += convert_uint8(vload8(0, item + wide(P, l, y, x)));
    }
    for (y = first; y < end; y++) {
        sum += convert_uint8(vload8(0, item + wide(P, l, y + r, x)));
        vstore8(convert_ushort8(sum >> (uint32_t)P[CL_SHIFT2]), 0,
                column + wide(P, l, y, x));
        sum -= convert_uint8(vload8(0, item + wide(P, l, y - r, x)));
    }
}

/* ---- reference view: moments and texture -------------------------------------- */

static uint32_t texture_at(__constant int32_t *P, __global const ushort *views,
                           int32_t x, int32_t y)
{
    uint32_t a = view_px(P, views, P[CL_REF], x, y);
    uint32_t t = 0;

    if (P[CL_USES_U]) {
        t += abs_diff(a, view_px(P, views, P[CL_REF], x - 1, y));
    }
    if (P[CL_USES_V]) {
        t += abs_diff(a, view_px(P, views, P[CL_REF], x, plfx_max_i32(y - 1, 0)));
    }
    return t;
}

/* Global size (nx, 1, bands): vertical sums of a, a^2 and texture: planes of sums. */
__kernel void ref_columns(__constant int32_t *P, __global const ushort *views,
                          __global uint32_t *sums)
{
    int32_t x = (int32_t)get_global_id(0);
    int32_t r = P[CL_WINDOW] / 2;
    int32_t first = r + (int32_t)get_global_id(2) * P[CL_BAND];
    int32_t end = plfx_min_i32(first + P[CL_BAND], P[CL_NY] - r);
    uint32_t a = 0;
    uint32_t aa = 0;
    uint32_t t = 0;
    int32_t y;

    if (x >= P[CL_NX] || first >= end) {
        return;
    }
    for (y = first - r; y < end + r; y++) {
        uint32_t v = view_px(P, views, P[CL_REF], x, y);
        a += v;
        aa += v * v;
        t += texture_at(P, views, x, y);
        if (y >= first + r) {
            sums[cell(P, 0, y - r, x)] = a;
            sums[cell(P, 1, y - r, x)] = aa;
            sums[cell(P, 2, y - r, x)] = t;
            v = view_px(P, views, P[CL_REF], x, y - 2 * r);
            a -= v;
            aa -= v * v;
            t -= texture_at(P, views, x, y - 2 * r);
        }
    }
}

typedef struct reference { /* window sums of the reference at one lens */
    uint64_t a, aa;
    uint32_t texture;
} reference;

static reference window_reference(__constant int32_t *P, __global const uint32_t *sums,
                                  int32_t x, int32_t y)
{
    int32_t r = P[CL_WINDOW] / 2;
    reference s = {0, 0, 0};
    int32_t i;

    for (i = x - r; i <= x + r; i++) {
        s.a += sums[cell(P, 0, y, i)];
        s.aa += sums[cell(P, 1, y, i)];
        s.texture += sums[cell(P, 2, y, i)];
    }
    return s;
}

/* ---- winner ------------------------------------------------------------------- */

typedef struct race {                     /* running winner over labels 0, 1, 2 ... */
    uint32_t best, second, before, after; /* costs; second NONE_SEEN at first */
    uint32_t last, older;                 /* cost of l-1; least of 0 .. l-2 */
    int32_t label;
} race;

static race race_start(uint32_t cost)
{
    race r = {cost, NONE_SEEN, 0, 0, cost, NONE_SEEN, 0};

    return r;
}

static race race_step(race r, int32_t l, uint32_t cost)
{
    if (cost < r.best) {
        r.second = r.older;
        r.before = r.last;
        r.best = cost;
        r.label = l;
    } else if (l == r.label + 1) {
        r.after = cost;
    } else {
        r.second = min(r.second, cost);
    }
    r.older = min(r.older, r.last);
    r.last = cost;
    return r;
}

typedef struct judged {
    uint32_t conf, weight;
} judged;

static judged judge(__constant int32_t *P, race r, uint32_t second, uint32_t g)
{
    judged j = {0, 0};

    if (P[CL_ZNCC]) {
        int32_t r1 = plfx_correlation_q15(r.best, g);
        int32_t r2 = plfx_correlation_q15(second, g);
        if (r1 > 0) {
            j.conf =
                plfx_margin_u16((uint32_t)(32768 - r1), (uint32_t)(32768 - r2), 512u);
            j.weight = (uint32_t)(2 * r1);
        }
    } else {
        j.conf = plfx_margin_u16(r.best, second, (uint32_t)P[CL_FLOOR]);
        j.weight = j.conf;
    }
    return j;
}

static int32_t slope_of(__constant int32_t *P, int32_t label_q4)
{
    int64_t span = (int64_t)P[CL_MAX] - P[CL_MIN];

    return P[CL_MIN] + (int32_t)plfx_div_round_i64(span * label_q4,
                                                   16 * ((int64_t)P[CL_LABELS] - 1));
}

/* span: x0, x1, y0, y1 of each label.  Writes one lens of the pair's planes. */
static void decide(__constant int32_t *P, race r, reference s, uint32_t g,
                   __global const short4 *span, int32_t x, int32_t y, size_t at,
                   __global int32_t *slope, __global ushort *conf,
                   __global ushort *weight, __global uchar *flags)
{
    int32_t apart = r.second < NONE_SEEN;
    uint32_t second = apart ? r.second : r.best;
    int32_t end = r.label == 0 || r.label == P[CL_LABELS] - 1;
    judged j = judge(P, r, second, g);
    short4 in = span[r.label];
    int32_t w2 = P[CL_WINDOW] * P[CL_WINDOW];
    int32_t f = 0;
    int32_t refused = 0;

    if (x < in.x || x > in.y || y < in.z || y > in.w) {
        refused |= FLAG_EDGE;
    }
    if (16u * s.texture < (uint32_t)(P[CL_TEXTURE] * w2) || (P[CL_ZNCC] && g == 0)) {
        refused |= FLAG_TEXTURE;
    }
    if ((apart && second == r.best) || j.conf < (uint32_t)P[CL_UNIQUE]) {
        refused |= FLAG_UNIQUE;
    }
    if (!end) {
        f = plfx_vertex_q4(r.after - r.best, r.before - r.best, P[CL_VEE]);
    }
    slope[at] = refused ? SLOPE_NONE : slope_of(P, 16 * r.label + f);
    conf[at] = (ushort)j.conf;
    weight[at] = (ushort)j.weight;
    flags[at] = (uchar)(refused | (end ? FLAG_RANGE_END : 0));
}

static int32_t inside(__constant int32_t *P, int32_t x, int32_t y)
{
    int32_t r = P[CL_WINDOW] / 2;

    return x >= r && y >= r && x < P[CL_NX] - r && y < P[CL_NY] - r;
}

static uint32_t window_cost(__constant int32_t *P, __global const ushort *column,
                            int32_t l, int32_t x, int32_t y)
{
    int32_t r = P[CL_WINDOW] / 2;
    uint32_t sum = 0;
    int32_t i;

    for (i = x - r; i <= x + r; i++) {
        sum += column[wide(P, l, y, i)];
    }
    return sum;
}

/* Global size (nx, ny): winners of pair p into planes [pairs][ny][nx]. */
__kernel void sad_winners(__constant int32_t *P, __global const ushort *column,
                          __global const uint32_t *sums, __global const short4 *span,
                          int32_t p, __global int32_t *slope, __global ushort *conf,
                          __global ushort *weight, __global uchar *flags)
{
    int32_t x = (int32_t)get_global_id(0);
    int32_t y = (int32_t)get_global_id(1);
    race r;
    int32_t l;

    if (!inside(P, x, y)) {
        return;
    }
    r = race_start(window_cost(P, column, 0, x, y));
    for (l = 1; l < P[CL_LABELS]; l++) {
        r = race_step(r, l, window_cost(P, column, l, x, y));
    }
    decide(P, r, window_reference(P, sums, x, y), 0, span + p * P[CL_LABELS], x, y,
           cell(P, p, y, x), slope, conf, weight, flags);
}

/* ---- zero-mean normalised cross-correlation ------------------------------------ */

/* Global size (nx, labels, bands): vertical sums of b, b^2, ab: 3 planes a label. */
__kernel void zncc_columns(__constant int32_t *P, __global const ushort *views,
                           __global const int2 *shift, int32_t p,
                           __global uint32_t *sums)
{
    int32_t x = (int32_t)get_global_id(0);
    int32_t l = (int32_t)get_global_id(1);
    int32_t r = P[CL_WINDOW] / 2;
    int32_t first = r + (int32_t)get_global_id(2) * P[CL_BAND];
    int32_t end = plfx_min_i32(first + P[CL_BAND], P[CL_NY] - r);
    int32_t k = pair_view(P, p);
    int2 s = shift[k * P[CL_LABELS] + l];
    uint32_t b = 0;
    uint32_t bb = 0;
    uint32_t ab = 0;
    int32_t y;

    if (x >= P[CL_NX] || first >= end) {
        return;
    }
    for (y = first - r; y < end + r; y++) {
        uint32_t v = sample_view(P, views, k, s, x, y);
        b += v;
        bb += v * v;
        ab += v * view_px(P, views, P[CL_REF], x, y);
        if (y >= first + r) {
            sums[cell(P, 3 * l, y - r, x)] = b;
            sums[cell(P, 3 * l + 1, y - r, x)] = bb;
            sums[cell(P, 3 * l + 2, y - r, x)] = ab;
            v = sample_view(P, views, k, s, x, y - 2 * r);
            b -= v;
            bb -= v * v;
            ab -= v * view_px(P, views, P[CL_REF], x, y - 2 * r);
        }
    }
}

static uint32_t zncc_cost(__constant int32_t *P, __global const uint32_t *sums,
                          int32_t l, int32_t x, int32_t y, uint64_t a, plfx_rsqrt ra)
{
    int32_t r = P[CL_WINDOW] / 2;
    uint64_t n = (uint64_t)(P[CL_WINDOW] * P[CL_WINDOW]);
    uint64_t b = 0;
    uint64_t bb = 0;
    uint64_t ab = 0;
    int32_t i;

    for (i = x - r; i <= x + r; i++) {
        b += sums[cell(P, 3 * l, y, i)];
        bb += sums[cell(P, 3 * l + 1, y, i)];
        ab += sums[cell(P, 3 * l + 2, y, i)];
    }
    return plfx_zncc_cost_of((int64_t)(n * ab) - (int64_t)(a * b), ra,
                             plfx_rsqrt_u64(n * bb - b * b));
}

/* Global size (nx, ny). */
__kernel void zncc_winners(__constant int32_t *P, __global const uint32_t *pair_sums,
                           __global const uint32_t *sums, __global const short4 *span,
                           int32_t p, __global int32_t *slope, __global ushort *conf,
                           __global ushort *weight, __global uchar *flags)
{
    int32_t x = (int32_t)get_global_id(0);
    int32_t y = (int32_t)get_global_id(1);
    uint64_t n = (uint64_t)(P[CL_WINDOW] * P[CL_WINDOW]);
    reference s;
    plfx_rsqrt ra;
    race r;
    int32_t l;

    if (!inside(P, x, y)) {
        return;
    }
    s = window_reference(P, sums, x, y);
    ra = plfx_rsqrt_u64(n * s.aa - s.a * s.a);
    r = race_start(zncc_cost(P, pair_sums, 0, x, y, s.a, ra));
    for (l = 1; l < P[CL_LABELS]; l++) {
        r = race_step(r, l, zncc_cost(P, pair_sums, l, x, y, s.a, ra));
    }
    decide(P, r, s, ra.g, span + p * P[CL_LABELS], x, y, cell(P, p, y, x), slope, conf,
           weight, flags);
}

/* ---- plenoptic stereo ----------------------------------------------------------- */

typedef struct pair_planes { /* results of every pair */
    __global const int32_t *slope;
    __global const ushort *conf, *weight;
    __global const uchar *flags;
    __global const ushort *baseline; /* weight of each pair */
} pair_planes;

/* Slope of pair p, NONE where it does not count: a winner at an end of the range is no
 * minimum and counts only when `ends` is set. */
static int32_t pair_slope(__constant int32_t *P, pair_planes q, int32_t p, int32_t x,
                          int32_t y, int32_t ends)
{
    size_t at = cell(P, p, y, x);

    return (q.flags[at] & FLAG_RANGE_END) && !ends ? SLOPE_NONE : q.slope[at];
}

static int32_t fuse_mean(__constant int32_t *P, pair_planes q, int32_t x, int32_t y,
                         int32_t ends)
{
    int64_t sum = 0;
    int64_t total = 0;
    int32_t p;

    for (p = 0; p < P[CL_PAIRS]; p++) {
        int32_t s = pair_slope(P, q, p, x, y, ends);
        if (s != SLOPE_NONE) {
            int64_t w = q.weight[cell(P, p, y, x)];
            sum += (int64_t)s * w;
            total += w;
        }
    }
    return total > 0 ? (int32_t)plfx_div_round_i64(sum, total) : SLOPE_NONE;
}

/* Weight of slopes up to and including `to`. */
static int64_t weight_to(__constant int32_t *P, pair_planes q, int32_t x, int32_t y,
                         int32_t ends, int32_t to)
{
    int64_t sum = 0;
    int32_t p;

    for (p = 0; p < P[CL_PAIRS]; p++) {
        int32_t s = pair_slope(P, q, p, x, y, ends);
        if (s != SLOPE_NONE && s <= to) {
            sum += q.baseline[p];
        }
    }
    return sum;
}

static int32_t next_slope(__constant int32_t *P, pair_planes q, int32_t x, int32_t y,
                          int32_t ends, int32_t above)
{
    int32_t best = INT32_MAX;
    int32_t p;

    for (p = 0; p < P[CL_PAIRS]; p++) {
        int32_t s = pair_slope(P, q, p, x, y, ends);
        if (s != SLOPE_NONE && s > above) {
            best = plfx_min_i32(best, s);
        }
    }
    return best;
}

static int32_t fuse_median(__constant int32_t *P, pair_planes q, int32_t x, int32_t y,
                           int32_t ends)
{
    int64_t total = weight_to(P, q, x, y, ends, INT32_MAX);
    int32_t median = SLOPE_NONE;
    int64_t below = 0;
    int32_t k;

    if (total == 0) {
        return SLOPE_NONE;
    }
    for (k = 0; k < P[CL_PAIRS] && 2 * below < total; k++) {
        median = next_slope(P, q, x, y, ends, median);
        below = weight_to(P, q, x, y, ends, median);
    }
    if (2 * below == total) {
        int64_t next = next_slope(P, q, x, y, ends, median);
        median = (int32_t)plfx_asr_i64(median + next + 1, 1);
    }
    return median;
}

typedef struct tally {
    int32_t measured, against;
    uint32_t conf, flags;
} tally;

static tally count_pairs(__constant int32_t *P, pair_planes q, int32_t x, int32_t y,
                         int32_t ends, int32_t fused)
{
    int64_t limit = 2 * ((int64_t)P[CL_MAX] - P[CL_MIN]) / (P[CL_LABELS] - 1);
    tally t = {0, 0, 0, 0};
    int32_t p;

    for (p = 0; p < P[CL_PAIRS]; p++) {
        int32_t s = pair_slope(P, q, p, x, y, ends);
        t.flags |= q.flags[cell(P, p, y, x)];
        if (s != SLOPE_NONE) {
            int64_t d = (int64_t)s - fused;
            t.measured++;
            t.conf += q.conf[cell(P, p, y, x)];
            t.against += d > limit || d < -limit;
        }
    }
    return t;
}

/* Global size (nx, ny): the map, from one pair or several. */
__kernel void fuse(__constant int32_t *P, __global const int32_t *slope,
                   __global const ushort *conf, __global const ushort *weight,
                   __global const uchar *flags, __global const ushort *baseline,
                   int32_t several, __global int32_t *out_slope,
                   __global ushort *out_conf, __global uchar *out_flags)
{
    int32_t x = (int32_t)get_global_id(0);
    int32_t y = (int32_t)get_global_id(1);
    int32_t s = SLOPE_NONE;
    uint32_t c = 0;
    uint32_t f = FLAG_EDGE;

    if (x >= P[CL_NX] || y >= P[CL_NY]) {
        return;
    }
    if (inside(P, x, y) && !several) {
        s = slope[cell(P, 0, y, x)];
        c = conf[cell(P, 0, y, x)];
        f = flags[cell(P, 0, y, x)];
    } else if (inside(P, x, y)) {
        pair_planes q = {slope, conf, weight, flags, baseline};
        int32_t ends;
        tally t;
        ends = count_pairs(P, q, x, y, 0, 0).measured == 0;
        s = P[CL_WEIGHTED] ? fuse_mean(P, q, x, y, ends)
                           : fuse_median(P, q, x, y, ends);
        t = count_pairs(P, q, x, y, ends, s);
        c = t.conf / (uint32_t)P[CL_PAIRS];
        f = s == SLOPE_NONE
                ? t.flags
                : (uint32_t)((ends ? FLAG_RANGE_END : 0) |
                             (3 * t.against > t.measured ? FLAG_OCCLUDED : 0));
    }
    out_slope[cell(P, 0, y, x)] = s;
    out_conf[cell(P, 0, y, x)] = (ushort)(s == SLOPE_NONE ? 0u : c);
    out_flags[cell(P, 0, y, x)] = (uchar)f;
}

/* ---- least-squares gradient ------------------------------------------------------ */

/* Rows y-1, y, y+1 of a view through a separable 3x3 stencil. */
static int64_t stencil(__constant int32_t *P, __global const ushort *views, int32_t k,
                       int32_t x, int32_t y, int3 along, int3 across)
{
    int64_t sum = 0;
    int32_t r;

    for (r = -1; r <= 1; r++) {
        int64_t w = r < 0 ? across.x : r == 0 ? across.y : across.z;
        int2 s = (int2)(0, 16 * r);
        sum += w * ((int64_t)along.x * sample_view(P, views, k, s, x - 1, y) +
                    (int64_t)along.y * sample_view(P, views, k, s, x, y) +
                    (int64_t)along.z * sample_view(P, views, k, s, x + 1, y));
    }
    return sum;
}

static int64_t spatial(__constant int32_t *P, __global const ushort *views,
                       int32_t minus, int32_t plus, int32_t x, int32_t y, int3 along,
                       int3 across)
{
    int64_t sum = PLFX_P_SIDE * (stencil(P, views, minus, x, y, along, across) +
                                 stencil(P, views, plus, x, y, along, across)) +
                  PLFX_P_MID * stencil(P, views, 0, x, y, along, across);

    return plfx_round_shift_i64(sum, 20);
}

static int64_t angular(__constant int32_t *P, __global const ushort *views,
                       int32_t minus, int32_t plus, int32_t x, int32_t y)
{
    int3 smooth = (int3)(PLFX_P_SIDE, PLFX_P_MID, PLFX_P_SIDE);
    int64_t diff = stencil(P, views, plus, x, y, smooth, smooth) -
                   stencil(P, views, minus, x, y, smooth, smooth);

    return plfx_round_shift_i64(PLFX_D_SIDE * diff, 20);
}

static plfx_products products_at(__constant int32_t *P, __global const ushort *views,
                                 int32_t x, int32_t y)
{
    int3 smooth = (int3)(PLFX_P_SIDE, PLFX_P_MID, PLFX_P_SIDE);
    int3 differ = (int3)(-PLFX_D_SIDE, 0, PLFX_D_SIDE);
    int64_t ix = spatial(P, views, 1, 2, x, y, differ, smooth);
    int64_t iy = spatial(P, views, 3, 4, x, y, smooth, differ);
    plfx_products c;

    c.xu = ix * angular(P, views, 1, 2, x, y);
    c.yv = iy * angular(P, views, 3, 4, x, y);
    c.xx = ix * ix;
    c.yy = iy * iy;
    c.xy = ix * iy;
    return c;
}

static plfx_products plus(plfx_products a, plfx_products b, int64_t sign)
{
    a.xu += sign * b.xu;
    a.yv += sign * b.yv;
    a.xx += sign * b.xx;
    a.yy += sign * b.yy;
    a.xy += sign * b.xy;
    return a;
}

/* Global size (nx, ny): products of lenses 1 .. nx-2, rows 1 .. ny-2. */
__kernel void gradient_products(__constant int32_t *P, __global const ushort *views,
                                __global plfx_products *cells)
{
    int32_t x = (int32_t)get_global_id(0);
    int32_t y = (int32_t)get_global_id(1);

    if (x >= 1 && y >= 1 && x < P[CL_NX] - 1 && y < P[CL_NY] - 1) {
        cells[cell(P, 0, y, x)] = products_at(P, views, x, y);
    }
}

/* Global size (nx, ny): the map. */
__kernel void gradient_map(__constant int32_t *P, __global const plfx_products *cells,
                           __global int32_t *slope, __global ushort *conf,
                           __global uchar *flags)
{
    int32_t x = (int32_t)get_global_id(0);
    int32_t y = (int32_t)get_global_id(1);
    int32_t r = P[CL_WINDOW] / 2;
    plfx_products w = {0, 0, 0, 0, 0};
    int32_t s = SLOPE_NONE;
    uint32_t c = 0;
    uint32_t f = FLAG_EDGE;
    int32_t i;
    int32_t j;

    if (x >= P[CL_NX] || y >= P[CL_NY]) {
        return;
    }
    if (x > r && y > r && x < P[CL_NX] - 1 - r && y < P[CL_NY] - 1 - r) {
        for (j = y - r; j <= y + r; j++) {
            for (i = x - r; i <= x + r; i++) {
                w = plus(w, cells[cell(P, 0, j, i)], 1);
            }
        }
        s = plfx_gradient_slope_q16(w, P[CL_COL], P[CL_ROW], P[CL_STEP]);
        c = plfx_gradient_conf_u16(w, P[CL_WINDOW] * P[CL_WINDOW], P[CL_BITS]);
        s = c < (uint32_t)P[CL_UNIQUE] ? SLOPE_NONE : s;
        f = s == SLOPE_NONE ? FLAG_TEXTURE : 0;
    }
    slope[cell(P, 0, y, x)] = s;
    conf[cell(P, 0, y, x)] = (ushort)(s == SLOPE_NONE ? 0u : c);
    flags[cell(P, 0, y, x)] = (uchar)f;
}

/* ---- depth -------------------------------------------------------------------- */

/* Global size (nx, ny): micrometres of every slope, 0 where there is none. */
__kernel void depth(__constant int32_t *P, __global const int32_t *slope,
                    __global uint32_t *um)
{
    int32_t x = (int32_t)get_global_id(0);
    int32_t y = (int32_t)get_global_id(1);
    int64_t gain =
        (int64_t)((uint64_t)(uint32_t)P[CL_HIGH] << 32 | (uint64_t)(uint32_t)P[CL_LOW]);
    int32_t s;
    int32_t inverse;

    if (x >= P[CL_NX] || y >= P[CL_NY]) {
        return;
    }
    s = slope[cell(P, 0, y, x)];
    inverse = plfx_inverse_q24(P[CL_INVERSE], gain, s);
    um[cell(P, 0, y, x)] = s == SLOPE_NONE ? 0u
                           : inverse <= 0  ? 0xffffffffu
                                           : plfx_micrometres(inverse);
}
