/* SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L
#include "recording.h"

#include "checksum.h"
#include "store/bytes.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#define HEADER    4096u
#define HEAD      64u
#define BLOCK     512u
#define AT_CRC    60u /* in header and head: CRC of the bytes before it */
#define CHUNK     65536u
#define FILE_MODE 0644

static const uint8_t file_magic[8] = {'P', 'L', 'X', 'R', 'E', 'C', 1, 0};
static const uint8_t head_magic[4] = {'P', 'F', 'R', 'M'};

static plfx_status io(plfx_recording *r)
{
    r->error = errno;
    return PLFX_E_IO;
}

static uint64_t record_at(const plfx_recording *r, uint64_t i)
{
    return HEADER + i * r->stride;
}

/* Read n bytes; E_FORMAT at the end of the file. */
static plfx_status read_at(plfx_recording *r, uint64_t at, uint8_t *b, size_t n)
{
    while (n > 0) { /* at most n rounds */
        ssize_t k = pread(r->file, b, n, (off_t)at);
        if (k < 0 && errno == EINTR) {
            continue;
        }
        if (k <= 0) {
            return k < 0 ? io(r) : PLFX_E_FORMAT;
        }
        b += k;
        at += (uint64_t)k;
        n -= (size_t)k;
    }
    return PLFX_OK;
}

static int info_ok(const plfx_recording_info *i)
{
    return plfx_raw_bytes(i->format, i->w, i->h) != 0 && i->format != PLFX_RAW_U16 &&
           i->bits >= 8 && i->bits <= 16 && i->bayer <= PLFX_BAYER_BGGR;
}

static void derive(plfx_recording *r)
{
    r->payload = (uint32_t)plfx_raw_bytes(r->info.format, r->info.w, r->info.h);
    r->stride = ((uint64_t)HEAD + r->payload + BLOCK - 1u) / BLOCK * BLOCK;
}

static void put_header(uint8_t *b, const plfx_recording *r)
{
    memset(b, 0, HEADER);
    memcpy(b, file_magic, sizeof file_magic);
    plfx_store_u32(b + 8, (uint32_t)r->info.w);
    plfx_store_u32(b + 12, (uint32_t)r->info.h);
    b[16] = r->info.format;
    b[17] = r->info.bits;
    b[18] = r->info.bayer;
    plfx_store_u32(b + 20, r->info.camera_id);
    plfx_store_u32(b + 24, r->info.table_crc);
    plfx_store_u32(b + 28, r->payload);
    plfx_store_u64(b + 32, r->stride);
    plfx_store_u32(b + AT_CRC, plfx_checksum(0, b, AT_CRC));
}

static plfx_status take_header(plfx_recording *r)
{
    uint8_t b[HEAD];
    plfx_status status = read_at(r, 0, b, sizeof b);
    uint32_t w = plfx_load_u32(b + 8);
    uint32_t h = plfx_load_u32(b + 12);

    if (status != PLFX_OK) {
        return status;
    }
    if (memcmp(b, file_magic, sizeof file_magic) != 0 ||
        plfx_checksum(0, b, AT_CRC) != plfx_load_u32(b + AT_CRC) || w > 32767u ||
        h > 32767u) {
        return PLFX_E_FORMAT;
    }
    r->info.w = (int32_t)w;
    r->info.h = (int32_t)h;
    r->info.format = b[16];
    r->info.bits = b[17];
    r->info.bayer = b[18];
    r->info.camera_id = plfx_load_u32(b + 20);
    r->info.table_crc = plfx_load_u32(b + 24);
    if (!info_ok(&r->info)) {
        return PLFX_E_FORMAT;
    }
    derive(r);
    return r->payload == plfx_load_u32(b + 28) && r->stride == plfx_load_u64(b + 32)
               ? PLFX_OK
               : PLFX_E_FORMAT;
}

static void put_head(uint8_t *b, const plfx_recording *r, const plfx_camera_frame *f)
{
    memset(b, 0, HEAD);
    memcpy(b, head_magic, sizeof head_magic);
    plfx_store_u32(b + 4, f->sequence);
    plfx_store_u64(b + 8, f->time_ns);
    plfx_store_u64(b + 16, r->count);
    b[24] = f->clock;
    b[25] = r->info.format;
    plfx_store_u32(b + 28, f->dropped);
    plfx_store_u32(b + 32, r->payload);
    plfx_store_u32(b + 36, plfx_checksum(0, f->raw.bytes, r->payload));
    plfx_store_u32(b + AT_CRC, plfx_checksum(0, b, AT_CRC));
}

/* Head of record i into *f, CRC of its payload into *crc. */
static plfx_status take_head(plfx_recording *r, uint64_t i, plfx_camera_frame *f,
                             uint32_t *crc)
{
    uint8_t b[HEAD];
    plfx_status status = read_at(r, record_at(r, i), b, sizeof b);

    if (status != PLFX_OK) {
        return status;
    }
    if (memcmp(b, head_magic, sizeof head_magic) != 0 ||
        plfx_checksum(0, b, AT_CRC) != plfx_load_u32(b + AT_CRC) ||
        plfx_load_u64(b + 16) != i || plfx_load_u32(b + 32) != r->payload) {
        return PLFX_E_FORMAT;
    }
    memset(f, 0, sizeof *f);
    f->sequence = plfx_load_u32(b + 4);
    f->time_ns = plfx_load_u64(b + 8);
    f->clock = b[24];
    f->dropped = plfx_load_u32(b + 28);
    f->bayer = r->info.bayer;
    f->rows = r->info.h;
    f->raw.size = r->payload;
    f->raw.format = r->info.format;
    f->raw.bits = r->info.bits;
    f->raw.w = r->info.w;
    f->raw.h = r->info.h;
    *crc = plfx_load_u32(b + 36);
    return PLFX_OK;
}

/* Do all bytes of record i hold? */
static plfx_status check_record(plfx_recording *r, uint64_t i)
{
    uint8_t part[CHUNK];
    plfx_camera_frame f;
    uint32_t want;
    uint32_t crc = 0;
    uint32_t done;
    plfx_status status = take_head(r, i, &f, &want);

    for (done = 0; status == PLFX_OK && done < r->payload; done += CHUNK) {
        size_t k = r->payload - done < CHUNK ? r->payload - done : CHUNK;
        status = read_at(r, record_at(r, i) + HEAD + done, part, k);
        if (status == PLFX_OK) {
            crc = plfx_checksum(crc, part, k);
        }
    }
    return status != PLFX_OK ? status : crc == want ? PLFX_OK : PLFX_E_FORMAT;
}

/* Records up to the last whole one. */
static plfx_status find_end(plfx_recording *r)
{
    struct stat about;
    uint64_t n;

    if (fstat(r->file, &about) != 0) {
        return io(r);
    }
    if ((uint64_t)about.st_size < HEADER) {
        return PLFX_E_FORMAT;
    }
    /* a record is whole without the padding behind its payload */
    n = ((uint64_t)about.st_size - HEADER + r->stride - HEAD - r->payload) / r->stride;
    for (; n > 0; n--) {
        plfx_status status = check_record(r, n - 1);
        if (status == PLFX_E_IO) {
            return status;
        }
        if (status == PLFX_OK) {
            break;
        }
    }
    r->count = n;
    r->synced = n;
    r->cut = (uint64_t)about.st_size > record_at(r, n)
                 ? (uint64_t)about.st_size - record_at(r, n)
                 : 0;
    return PLFX_OK;
}

static plfx_status cut_off(plfx_recording *r)
{
    return ftruncate(r->file, (off_t)record_at(r, r->count)) == 0 ? PLFX_OK : io(r);
}

plfx_status plfx_recording_create(plfx_recording *r, const char *path,
                                  const plfx_recording_info *info)
{
    uint8_t b[HEADER];

    if (!r || !path || !info || !info_ok(info)) {
        return PLFX_E_ARG;
    }
    memset(r, 0, sizeof *r);
    r->info = *info;
    r->writable = 1;
    derive(r);
    put_header(b, r);
    r->file = open(path, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, FILE_MODE);
    if (r->file < 0) {
        return io(r);
    }
    errno = ENOSPC; /* for a short write, which sets none */
    if (pwrite(r->file, b, HEADER, 0) != (ssize_t)HEADER || fsync(r->file) != 0) {
        plfx_status status = io(r);
        plfx_recording_close(r);
        (void)unlink(path); /* a file without a header is no recording */
        return status;
    }
    return PLFX_OK;
}

plfx_status plfx_recording_open(plfx_recording *r, const char *path, int append)
{
    plfx_status status;

    if (!r || !path) {
        return PLFX_E_ARG;
    }
    memset(r, 0, sizeof *r);
    r->writable = append;
    r->file = open(path, (append ? O_RDWR : O_RDONLY) | O_CLOEXEC);
    if (r->file < 0) {
        return io(r);
    }
    status = take_header(r);
    if (status == PLFX_OK) {
        status = find_end(r);
    }
    if (status == PLFX_OK && append) {
        status = cut_off(r);
    }
    if (status != PLFX_OK) {
        plfx_recording_close(r);
    }
    return status;
}

/* Write all of the parts at `at`; consumes them. */
static plfx_status write_at(plfx_recording *r, uint64_t at, struct iovec *part, int n)
{
    if (lseek(r->file, (off_t)at, SEEK_SET) < 0) {
        return io(r);
    }
    while (n > 0) { /* at most a round a byte */
        ssize_t k = writev(r->file, part, n);
        if (k < 0 && errno == EINTR) {
            continue;
        }
        if (k <= 0) {
            return io(r);
        }
        while (n > 0 && (size_t)k >= part->iov_len) { /* at most 3 rounds */
            k -= (ssize_t)part->iov_len;
            part++;
            n--;
        }
        if (n > 0) {
            part->iov_base = (uint8_t *)part->iov_base + k;
            part->iov_len -= (size_t)k;
        }
    }
    return PLFX_OK;
}

static int fits(const plfx_recording *r, const plfx_camera_frame *f)
{
    return f->raw.bytes && f->raw.w == r->info.w && f->raw.h == r->info.h &&
           f->raw.format == r->info.format && f->raw.bits == r->info.bits &&
           f->raw.size >= r->payload && f->rows >= f->raw.h;
}

plfx_status plfx_recording_add(plfx_recording *r, const plfx_camera_frame *frame)
{
    static const uint8_t zeros[BLOCK] = {0};
    uint8_t head[HEAD];
    struct iovec part[3];
    plfx_status status;

    if (!r || !frame || !fits(r, frame)) {
        return PLFX_E_ARG;
    }
    if (r->file < 0 || !r->writable) {
        return PLFX_E_STATE;
    }
    put_head(head, r, frame);
    part[0].iov_base = head;
    part[0].iov_len = HEAD;
    part[1].iov_base = (void *)(uintptr_t)frame->raw.bytes; /* writev only reads */
    part[1].iov_len = r->payload;
    part[2].iov_base = (void *)(uintptr_t)zeros;
    part[2].iov_len = (size_t)(r->stride - HEAD - r->payload);
    status = write_at(r, record_at(r, r->count), part, part[2].iov_len ? 3 : 2);
    if (status != PLFX_OK) {
        int error = r->error;
        (void)cut_off(r);
        r->error = error;
        return status;
    }
    r->count++;
    return PLFX_OK;
}

plfx_status plfx_recording_sync(plfx_recording *r)
{
    if (!r || r->file < 0 || !r->writable) {
        return PLFX_E_STATE;
    }
    if (fdatasync(r->file) != 0) {
        return io(r);
    }
    r->synced = r->count;
    return PLFX_OK;
}

plfx_status plfx_recording_read(plfx_recording *r, uint64_t i, uint8_t *bytes, size_t n,
                                plfx_camera_frame *frame)
{
    plfx_status status;
    plfx_camera_frame f;
    uint32_t crc;

    if (!r || r->file < 0 || !frame || i >= r->count) {
        return PLFX_E_ARG;
    }
    if (bytes && n < r->payload) {
        return PLFX_E_SIZE;
    }
    status = take_head(r, i, &f, &crc);
    if (status == PLFX_OK && bytes) {
        status = read_at(r, record_at(r, i) + HEAD, bytes, r->payload);
        if (status == PLFX_OK && plfx_checksum(0, bytes, r->payload) != crc) {
            status = PLFX_E_FORMAT;
        }
        f.raw.bytes = bytes;
    }
    if (status == PLFX_OK) {
        *frame = f;
    }
    return status;
}

void plfx_recording_ahead(const plfx_recording *r, uint64_t i, uint64_t n)
{
    if (r && r->file >= 0 && i < r->count) {
        (void)posix_fadvise(r->file, (off_t)record_at(r, i), (off_t)(n * r->stride),
                            POSIX_FADV_WILLNEED);
    }
}

void plfx_recording_close(plfx_recording *r)
{
    if (r && r->file >= 0) {
        (void)close(r->file);
        r->file = -1;
    }
}
