/* SPDX-License-Identifier: MIT
 * Serve frames as a GigE Vision camera on the loopback of a network of its own while
 * a command runs there.
 *
 * usage: serve CAMERA.xml FRAMES.raw WxH PFNC-CODE LOST[,FAULT=N...] COMMAND...
 * Frames lie one behind the other in the file and go round; LOST is the share of
 * packets lost, 0 to 1.  Faults after N frames: gone (unplugged), back (the clock jumps
 * back by an hour), small (another height), byte (8-bit pixels).  Exit status: the
 * command's; 77 where no such network can be had. */
#define _GNU_SOURCE
#include "lo.h"

#include <arv.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>

static guint8 *frames;
static gsize size;
static gsize next;
static gint sent; /* frames */

static struct fault {
    const char *name;
    int after; /* frames; 0: never */
    int done;
} faults[] = {{"gone=", 0, 0}, {"back=", 0, 0}, {"small=", 0, 0}, {"byte=", 0, 0}};
enum { GONE, BACK, SMALL, BYTE, FAULTS };

static void fill(ArvBuffer *b, void *user, guint32 exposure, guint32 gain,
                 ArvPixelFormat format)
{
    gsize none;
    guint8 *to = (guint8 *)(guintptr)arv_buffer_get_data(b, &none);
    gsize n = arv_fake_camera_get_payload(user);

    (void)exposure;
    (void)gain;
    (void)format;
    if (next + n > size) {
        next = 0;
    }
    if (n <= size) {
        memcpy(to, frames + next, n);
        next += n;
    }
    g_atomic_int_inc(&sent);
    if (faults[BACK].after && sent > faults[BACK].after) {
        arv_buffer_set_timestamp(b, arv_buffer_get_timestamp(b) - 3600000000000u);
    }
}

static void read_faults(const char *text)
{
    int k;

    for (k = 0; k < FAULTS; k++) {
        const char *at = strstr(text, faults[k].name);
        faults[k].after = at ? atoi(at + strlen(faults[k].name)) : 0;
    }
}

static int due(int k)
{
    int now = faults[k].after && !faults[k].done &&
              g_atomic_int_get(&sent) >= faults[k].after;

    faults[k].done |= now;
    return now;
}

/* What happens to the camera while the command runs. */
static ArvGvFakeCamera *trouble(ArvGvFakeCamera *gv)
{
    ArvFakeCamera *c = gv ? arv_gv_fake_camera_get_fake_camera(gv) : NULL;
    guint32 h = 0;

    if (c && due(SMALL)) {
        arv_fake_camera_read_register(c, ARV_FAKE_CAMERA_REGISTER_HEIGHT, &h);
        arv_fake_camera_write_register(c, ARV_FAKE_CAMERA_REGISTER_HEIGHT, h - 8);
    }
    if (c && due(BYTE)) {
        arv_fake_camera_write_register(c, ARV_FAKE_CAMERA_REGISTER_PIXEL_FORMAT,
                                       ARV_PIXEL_FORMAT_MONO_8);
    }
    if (c && due(GONE)) {
        g_object_unref(gv);
        return NULL;
    }
    return gv;
}

static int run(char **command, const int *go)
{
    char c;

    (void)close(go[1]);
    if (read(go[0], &c, 1) != 1) {
        return 1;
    }
    (void)execvp(command[0], command);
    perror(command[0]);
    return 127;
}

static ArvGvFakeCamera *serve(char **argv)
{
    ArvGvFakeCamera *gv = arv_gv_fake_camera_new_full("127.0.0.1", "PLFX", argv[1]);
    ArvFakeCamera *c = arv_gv_fake_camera_get_fake_camera(gv);
    guint32 w = 0;
    guint32 h = 0;

    if (!arv_gv_fake_camera_is_running(gv) || sscanf(argv[3], "%ux%u", &w, &h) != 2) {
        return NULL;
    }
    arv_fake_camera_write_register(c, ARV_FAKE_CAMERA_REGISTER_SENSOR_WIDTH, w);
    arv_fake_camera_write_register(c, ARV_FAKE_CAMERA_REGISTER_SENSOR_HEIGHT, h);
    arv_fake_camera_write_register(c, ARV_FAKE_CAMERA_REGISTER_WIDTH, w);
    arv_fake_camera_write_register(c, ARV_FAKE_CAMERA_REGISTER_HEIGHT, h);
    arv_fake_camera_write_register(c, ARV_FAKE_CAMERA_REGISTER_PIXEL_FORMAT,
                                   (guint32)strtoul(argv[4], NULL, 0));
    g_random_set_seed(42);
    read_faults(argv[5]);
    g_object_set(gv, "gvsp-lost-ratio", atof(argv[5]), NULL);
    arv_fake_camera_set_fill_pattern(c, fill, c);
    return gv;
}

int main(int argc, char **argv)
{
    ArvGvFakeCamera *gv;
    int status = 1;
    int go[2];
    pid_t child;

    if (argc < 7 || !g_file_get_contents(argv[2], (gchar **)&frames, &size, NULL)) {
        fprintf(stderr,
                "usage: serve CAMERA.xml FRAMES.raw WxH CODE LOST COMMAND...\n");
        return 2;
    }
    if (lo_enter() != 0) {
        printf("skipped: no network namespace of our own on this system\n");
        return 77;
    }
    if (pipe(go) != 0 || (child = fork()) < 0) { /* before there are threads */
        return 1;
    }
    if (child == 0) {
        return run(argv + 6, go);
    }
    gv = serve(argv);
    if (gv == NULL || write(go[1], "g", 1) != 1) {
        fprintf(stderr, "serve: no camera\n");
        return 1;
    }
    while (waitpid(child, &status, WNOHANG) == 0) {
        gv = trouble(gv);
        g_usleep(5000);
    }
    g_clear_object(&gv);
    g_free(frames);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}
