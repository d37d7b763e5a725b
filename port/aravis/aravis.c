/* SPDX-License-Identifier: MIT */
#include "aravis.h"
#include "pfnc.h"

#include <arv.h>
#include <string.h>

#define MICRO      1000u
#define ID_HIGHEST 65535u  /* of a 16-bit frame number; 0 is never sent */
#define ASK_US     1000000 /* between questions for the camera's clock */

/* Keep Aravis' words; drop the error. */
static plfx_status failed(plfx_aravis *a, GError *error, plfx_status status)
{
    a->message[0] = 0;
    if (error) {
        (void)g_strlcpy(a->message, error->message, sizeof a->message);
        g_error_free(error);
    }
    return status;
}

/* Called by Aravis' own thread. */
static void on_lost(ArvDevice *device, plfx_aravis *a)
{
    (void)device;
    g_atomic_int_set(&a->lost, 1);
}

static void set_region(plfx_aravis *a, ArvCamera *c, GError **e)
{
    const plfx_camera_cfg *cfg = &a->cfg;

    if (cfg->w > 0 && cfg->h > 0) {
        arv_camera_set_region(c, cfg->x0, cfg->y0, cfg->w, cfg->h, e);
    }
}

static void set_format(plfx_aravis *a, ArvCamera *c, GError **e)
{
    uint32_t code = plfx_pfnc_code(a->cfg.format, a->cfg.bits, a->cfg.bayer);

    if (a->cfg.bits == 0) {
        return; /* as the camera stands */
    }
    if (code == 0) {
        g_set_error_literal(e, ARV_DEVICE_ERROR, ARV_DEVICE_ERROR_INVALID_PARAMETER,
                            "no such pixel format");
        return;
    }
    arv_camera_set_pixel_format(c, code, e);
}

static void set_light(plfx_aravis *a, ArvCamera *c, GError **e)
{
    if (a->cfg.exposure_us != 0) {
        arv_camera_set_exposure_time(c, a->cfg.exposure_us, e);
    }
    if (*e == NULL && a->cfg.gain_mdb != INT32_MIN &&
        arv_camera_is_gain_available(c, NULL)) {
        arv_camera_set_gain(c, a->cfg.gain_mdb / 1000.0, e);
    }
    if (*e == NULL && a->cfg.rate_mhz != 0) {
        arv_camera_set_frame_rate(c, a->cfg.rate_mhz / 1000.0, e);
    }
}

static void set_wire(plfx_aravis *a, ArvCamera *c, GError **e)
{
    if (!arv_camera_is_gv_device(c)) {
        return;
    }
    if (a->cfg.packet_size != 0) {
        arv_camera_gv_set_packet_size(c, (gint)a->cfg.packet_size, e);
    } else {
        (void)arv_camera_gv_auto_packet_size(c, NULL);
    }
    a->cfg.packet_size = arv_camera_gv_get_packet_size(c, NULL);
}

/* Ask for IEEE 1588 where it is offered, under its name of today or of old. */
static void set_clock(plfx_aravis *a, ArvCamera *c)
{
    static const char *const names[] = {"PtpEnable", "GevIEEE1588"};
    size_t k;

    a->ptp = 0;
    for (k = 0; k < 2; k++) {
        if (arv_camera_is_feature_available(c, names[k], NULL)) {
            arv_camera_set_boolean(c, names[k], TRUE, NULL);
            a->ptp = 1;
        }
    }
}

/* Does the camera's clock keep the network's time? */
static int locked(ArvCamera *c)
{
    static const char *const names[] = {"PtpStatus", "GevIEEE1588Status"};
    size_t k;

    if (arv_camera_is_feature_available(c, "PtpDataSetLatch", NULL)) {
        arv_camera_execute_command(c, "PtpDataSetLatch", NULL);
    }
    for (k = 0; k < 2; k++) {
        const char *now = arv_camera_is_feature_available(c, names[k], NULL)
                              ? arv_camera_get_string(c, names[k], NULL)
                              : NULL;
        if (now && (strcmp(now, "Slave") == 0 || strcmp(now, "Master") == 0)) {
            return 1;
        }
    }
    return 0;
}

/* Ask for the clock; a lock comes seconds after the start, and may be lost. */
static void ask_clock(plfx_aravis *a)
{
    a->clock = a->ptp && locked(a->device) ? PLFX_CLOCK_PTP : PLFX_CLOCK_CAMERA;
    a->asked_us = g_get_monotonic_time();
}

static plfx_status configure(plfx_aravis *a, ArvCamera *c)
{
    GError *e = NULL;

    set_format(a, c, &e);
    if (e == NULL) {
        set_region(a, c, &e);
    }
    if (e == NULL) {
        set_light(a, c, &e);
    }
    if (e == NULL) {
        set_wire(a, c, &e);
    }
    if (e == NULL) {
        set_clock(a, c);
        arv_camera_set_acquisition_mode(c, ARV_ACQUISITION_MODE_CONTINUOUS, NULL);
    }
    return e == NULL ? PLFX_OK : failed(a, e, PLFX_E_ARG);
}

uint32_t plfx_aravis_id(const char *serial)
{
    uint32_t hash = 2166136261u;
    uint32_t number = 0;
    size_t n = strlen(serial);
    size_t k;

    for (k = 0; k < n; k++) {
        hash = (hash ^ (uint8_t)serial[k]) * 16777619u;
        number = number * 10u + (uint32_t)(serial[k] - '0');
    }
    return n == 0                                         ? 0u
           : n <= 9u && strspn(serial, "0123456789") == n ? number
                                                          : hash & 0x7fffffffu;
}

static void identify(plfx_aravis *a, ArvCamera *c)
{
    const char *serial = arv_camera_get_device_serial_number(c, NULL);

    a->camera_id = serial ? plfx_aravis_id(serial) : 0u;
}

static void keep(char *to, size_t n, const char *text)
{
    (void)g_strlcpy(to, text, n);
}

/* What the camera settled on. */
static plfx_status read_back(plfx_aravis *a, ArvCamera *c)
{
    GError *e = NULL;
    const plfx_pfnc *f;
    gint x = 0;
    gint y = 0;
    gint w = 0;
    gint h = 0;

    arv_camera_get_region(c, &x, &y, &w, &h, &e);
    if (e == NULL) {
        a->code = arv_camera_get_pixel_format(c, &e);
    }
    if (e == NULL) {
        a->payload = arv_camera_get_payload(c, &e);
    }
    if (e != NULL) {
        return failed(a, e, PLFX_E_DEVICE);
    }
    f = plfx_pfnc_find(a->code);
    if (f == NULL || (a->cfg.w > 0 && a->cfg.w != w) ||
        (a->cfg.h > 0 && a->cfg.h != h)) {
        keep(a->message, sizeof a->message, "the camera chose another size or format");
        return PLFX_E_ARG;
    }
    a->cfg.x0 = x;
    a->cfg.y0 = y;
    a->cfg.w = w;
    a->cfg.h = h;
    a->cfg.format = f->format;
    a->cfg.bits = f->bits;
    a->cfg.bayer = f->bayer;
    a->exposure_us = (uint32_t)arv_camera_get_exposure_time(c, NULL);
    return plfx_raw_bytes(f->format, w, h) != 0 ? PLFX_OK : PLFX_E_ARG;
}

/* Every slot becomes a buffer of the stream. */
static plfx_status make_stream(plfx_aravis *a, ArvCamera *c)
{
    GError *e = NULL;
    ArvStream *stream;
    int32_t k;

    if (a->pool.slot_size < a->payload) {
        return PLFX_E_SIZE;
    }
    stream = arv_camera_create_stream(c, NULL, NULL, &e);
    if (stream == NULL) {
        return failed(a, e, PLFX_E_DEVICE);
    }
    a->stream = stream;
    for (k = 0; k < a->pool.slots; k++) {
        arv_stream_push_buffer(
            stream, arv_buffer_new(a->pool.slot_size,
                                   a->pool.bytes + (size_t)k * a->pool.slot_size));
    }
    return PLFX_OK;
}

static void aravis_close(void *context)
{
    plfx_aravis *a = context;
    int32_t k;

    for (k = 0; k < PLFX_ARAVIS_SLOTS; k++) {
        g_clear_object(&a->taken[k]);
    }
    g_clear_object(&a->stream);
    if (a->device) {
        (void)g_signal_handlers_disconnect_by_data(
            arv_camera_get_device(ARV_CAMERA(a->device)), a);
    }
    g_clear_object(&a->device);
    a->running = 0;
}

static plfx_status aravis_open(void *context, plfx_camera_cfg *cfg,
                               const plfx_pool *pool)
{
    plfx_aravis *a = context;
    GError *e = NULL;
    ArvCamera *c;
    plfx_status status;

    if (!cfg || !pool || !pool->bytes || pool->slots < 1 ||
        pool->slots > PLFX_ARAVIS_SLOTS || a->device) {
        return PLFX_E_ARG;
    }
    c = arv_camera_new(a->name, &e);
    if (c == NULL) {
        return failed(a, e, PLFX_E_DEVICE);
    }
    a->device = c;
    a->cfg = *cfg;
    a->pool = *pool;
    a->lost = 0;
    status = configure(a, c);
    if (status == PLFX_OK) {
        status = read_back(a, c);
    }
    if (status == PLFX_OK) {
        status = make_stream(a, c);
    }
    if (status != PLFX_OK) {
        aravis_close(a);
        return status;
    }
    g_signal_connect(arv_camera_get_device(c), "control-lost", G_CALLBACK(on_lost), a);
    identify(a, c);
    *cfg = a->cfg;
    return PLFX_OK;
}

static plfx_status aravis_start(void *context)
{
    plfx_aravis *a = context;
    GError *e = NULL;
    ArvBuffer *old;

    if (!a->device || a->running) {
        return PLFX_E_STATE;
    }
    while ((old = arv_stream_try_pop_buffer(a->stream)) != NULL) { /* at most slots */
        arv_stream_push_buffer(a->stream, old);
    }
    memset(&a->count, 0, sizeof a->count);
    a->last_id = 0;
    a->broken = 0;
    a->sequence = 0;
    a->last_good = 0;
    a->last_ns = 0;
    a->last_clock = PLFX_CLOCK_NONE;
    ask_clock(a);
    arv_camera_start_acquisition(a->device, &e);
    if (e != NULL) {
        return failed(a, e, PLFX_E_DEVICE);
    }
    a->running = 1;
    return PLFX_OK;
}

/* Widen the number of a frame that came whole; numbers that were skipped and did not
 * arrive broken are missed frames.  A broken frame's own number is not used: it lies in
 * the leader, and that packet may be the one that was lost. */
static void follow(plfx_aravis *a, uint64_t id)
{
    uint64_t step = 1u + a->broken;

    if (a->last_id != 0 && id != 0) {
        step = id > a->last_id           ? id - a->last_id
               : a->last_id > ID_HIGHEST ? 1u /* 64-bit numbers do not come round */
                                         : id + ID_HIGHEST - a->last_id;
        if (step > ID_HIGHEST / 2 || step <= a->broken) {
            step = 1u + a->broken; /* the camera began to count anew */
        }
    }
    a->sequence += step;
    a->count.missed += step - 1u - a->broken;
    a->last_id = id;
    a->broken = 0;
}

static int fits(const plfx_aravis *a, ArvBuffer *b)
{
    size_t size = 0;
    const void *data = arv_buffer_get_data(b, &size);

    return data && arv_buffer_get_payload_type(b) == ARV_BUFFER_PAYLOAD_TYPE_IMAGE &&
           arv_buffer_get_image_pixel_format(b) == a->code &&
           arv_buffer_get_image_width(b) == a->cfg.w &&
           arv_buffer_get_image_height(b) == a->cfg.h &&
           size >= plfx_raw_bytes(a->cfg.format, a->cfg.w, a->cfg.h);
}

/* Time of the middle of the exposure; the arrival's where the camera has no clock. */
static uint64_t time_of(const plfx_aravis *a, ArvBuffer *b, uint8_t *clock)
{
    uint64_t ns = arv_buffer_get_timestamp(b);

    *clock = a->clock;
    if (ns == 0) {
        *clock = PLFX_CLOCK_UTC;
        return arv_buffer_get_system_timestamp(b);
    }
    return ns + (uint64_t)a->exposure_us * MICRO / 2u;
}

static void hand_out(plfx_aravis *a, ArvBuffer *b, plfx_camera_frame *f)
{
    size_t size = 0;
    const uint8_t *data = arv_buffer_get_data(b, &size);

    memset(f, 0, sizeof *f);
    f->raw.bytes = data;
    f->raw.size = size;
    f->raw.format = a->cfg.format;
    f->raw.bits = a->cfg.bits;
    f->raw.w = a->cfg.w;
    f->raw.h = a->cfg.h;
    f->rows = a->cfg.h;
    f->bayer = a->cfg.bayer;
    f->slot = (int32_t)((size_t)(data - a->pool.bytes) / a->pool.slot_size);
    f->sequence = (uint32_t)a->sequence;
    f->dropped = (uint32_t)(a->sequence - a->last_good - 1u);
    f->time_ns = time_of(a, b, &f->clock);
    a->count.back += f->clock == a->last_clock && f->time_ns < a->last_ns;
    a->last_ns = f->time_ns;
    a->last_clock = f->clock;
    a->last_good = a->sequence;
    a->count.good++;
    a->taken[f->slot] = b;
}

/* One buffer that arrived: handed out, or counted and pushed back. */
static int judge(plfx_aravis *a, ArvBuffer *b, plfx_camera_frame *frame)
{
    ArvBufferStatus status = arv_buffer_get_status(b);

    if (status == ARV_BUFFER_STATUS_SUCCESS) {
        follow(a, arv_buffer_get_frame_id(b));
        if (fits(a, b)) {
            hand_out(a, b, frame);
            return 1;
        }
        a->count.misfit++;
    } else if (status == ARV_BUFFER_STATUS_SIZE_MISMATCH ||
               status == ARV_BUFFER_STATUS_WRONG_PACKET_ID) {
        a->count.misfit++;
        a->broken++;
    } else if (status != ARV_BUFFER_STATUS_ABORTED &&
               status != ARV_BUFFER_STATUS_CLEARED) {
        a->count.incomplete++;
        a->broken++;
    }
    arv_stream_push_buffer(a->stream, b);
    return 0;
}

static int none_free(const plfx_aravis *a)
{
    int32_t k;

    for (k = 0; k < a->pool.slots; k++) {
        if (!a->taken[k]) {
            return 0;
        }
    }
    return 1;
}

static plfx_status aravis_acquire(void *context, uint32_t timeout_ms,
                                  plfx_camera_frame *frame)
{
    plfx_aravis *a = context;
    gint64 until = g_get_monotonic_time() + (gint64)timeout_ms * MICRO;
    gint64 left = (gint64)timeout_ms * MICRO;

    if (!a->running || !frame) {
        return a->running ? PLFX_E_ARG : PLFX_E_STATE;
    }
    if (none_free(a)) {
        a->count.starved++;
        return PLFX_E_STATE;
    }
    if (a->ptp && g_get_monotonic_time() - a->asked_us > ASK_US) {
        ask_clock(a);
    }
    do { /* at most until the timeout */
        ArvBuffer *b = g_atomic_int_get(&a->lost)
                           ? NULL
                           : arv_stream_timeout_pop_buffer(a->stream, (guint64)left);
        if (b && judge(a, b, frame)) {
            return PLFX_OK;
        }
        if (g_atomic_int_get(&a->lost)) {
            return PLFX_E_DEVICE;
        }
        left = until - g_get_monotonic_time();
    } while (left > 0);
    return PLFX_E_TIMEOUT;
}

static plfx_status aravis_release(void *context, const plfx_camera_frame *frame)
{
    plfx_aravis *a = context;

    if (!frame || frame->slot < 0 || frame->slot >= a->pool.slots ||
        !a->taken[frame->slot]) {
        return PLFX_E_ARG;
    }
    arv_stream_push_buffer(a->stream, a->taken[frame->slot]);
    a->taken[frame->slot] = NULL;
    return PLFX_OK;
}

static plfx_status aravis_stop(void *context)
{
    plfx_aravis *a = context;
    GError *e = NULL;

    if (!a->running) {
        return PLFX_E_STATE;
    }
    a->running = 0;
    arv_camera_stop_acquisition(a->device, &e);
    return e == NULL ? PLFX_OK : failed(a, e, PLFX_E_DEVICE);
}

static void aravis_count(void *context, plfx_camera_count *count)
{
    plfx_aravis *a = context;
    guint64 underruns = 0;

    *count = a->count;
    if (a->stream) {
        arv_stream_get_statistics(a->stream, NULL, NULL, &underruns);
        count->starved += underruns;
    }
}

void plfx_aravis_init(plfx_aravis *a, const char *name)
{
    memset(a, 0, sizeof *a);
    a->name = name;
    a->camera.context = a;
    a->camera.open = aravis_open;
    a->camera.start = aravis_start;
    a->camera.acquire = aravis_acquire;
    a->camera.release = aravis_release;
    a->camera.stop = aravis_stop;
    a->camera.count = aravis_count;
    a->camera.close = aravis_close;
}
