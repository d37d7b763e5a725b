/* SPDX-License-Identifier: MIT
 * The table store under power cuts, failures and flipped bits. */
#include "../unit/suite.h"
#include "ram/ram.h"
#include "store/store.h"

#include "plenofix/lut.h"

#define ERASE 256u
#define SIZE  (ERASE * 8u)
#define TABLE 900u

static uint8_t flash[SIZE];
static uint8_t worn[SIZE];
static uint8_t flash_was[SIZE];
static uint8_t worn_was[SIZE];
static uint8_t tables[3][TABLE];
static plfx_ram ram;

/* A valid table with recognisable text. */
static uint32_t make_table(uint8_t *table, int32_t k, uint32_t camera)
{
    static uint8_t text[TABLE];
    plfx_lut_desc d;
    uint32_t bare;

    memset(&d, 0, sizeof d);
    memset(text, 'a' + k, sizeof text);
    d.camera_id = camera;
    d.sensor_w = d.sensor_h = 40;
    d.sensor_bits = 10;
    d.lattice.nx = d.lattice.ny = 2;
    d.lattice.origin.x_q16 = d.lattice.origin.y_q16 = 10 << 16;
    d.lattice.a.x_q22 = d.lattice.b.y_q22 = 10 * 4194304;
    d.meta = text;
    bare = (uint32_t)plfx_lut_bytes(&d);
    d.meta_len = TABLE - (uint32_t)k * 7u - bare;
    assert_int_equal(plfx_lut_write(&d, table, TABLE), PLFX_OK);
    return (uint32_t)plfx_lut_bytes(&d);
}

static uint32_t length_of(int32_t k)
{
    return make_table(tables[k], k, 7);
}

static void fresh(uint32_t program_size)
{
    assert_int_equal(plfx_ram_init(&ram, flash, worn, SIZE, ERASE, program_size),
                     PLFX_OK);
}

static plfx_store opened(void)
{
    plfx_store s;

    assert_int_equal(plfx_store_open(&s, &ram.block, 7), PLFX_OK);
    return s;
}

/* Which table the store holds after power-up; -1: none. */
static int32_t held(void)
{
    uint8_t back[TABLE];
    plfx_store s;
    int32_t k;

    plfx_ram_power(&ram);
    s = opened();
    if (s.slot < 0) {
        return -1;
    }
    assert_int_equal(plfx_store_read(&s, back, sizeof back), PLFX_OK);
    assert_memory_equal(plfx_store_table(&s), back, s.length);
    for (k = 0; k < 3; k++) {
        if (s.length == length_of(k) && memcmp(back, tables[k], s.length) == 0) {
            return k;
        }
    }
    fail_msg("the store holds neither table");
    return -2;
}

static void write_table(int32_t k)
{
    plfx_store s = opened();
    uint32_t n = length_of(k);

    assert_int_equal(plfx_store_write(&s, tables[k], n), PLFX_OK);
}

static void remember(void)
{
    memcpy(flash_was, flash, SIZE);
    memcpy(worn_was, worn, SIZE);
}

static void go_back(void)
{
    memcpy(flash, flash_was, SIZE);
    memcpy(worn, worn_was, SIZE);
    plfx_ram_power(&ram);
}

static void tables_replace_each_other(void **state)
{
    uint32_t unit;
    int32_t k;

    (void)state;
    for (unit = 1; unit <= 64; unit *= 2) {
        fresh(unit);
        assert_int_equal(held(), -1);
        for (k = 0; k < 9; k++) {
            write_table(k % 3);
            assert_int_equal(held(), k % 3);
        }
        assert_int_equal(opened().generation, 9);
        assert_int_equal(opened().wear, 5);
        assert_int_equal(opened().fell_back, 0);
        assert_int_equal(ram.misused, 0);
    }
}

/* Operations of an update, and the bytes of each. */
static uint32_t operations(uint32_t *bytes)
{
    plfx_store s = opened();
    uint32_t n = length_of(2);
    uint32_t k;
    uint32_t total;

    plfx_ram_power(&ram);
    assert_int_equal(plfx_store_write(&s, tables[2], n), PLFX_OK);
    total = ram.count;
    for (k = 0; k < total; k++) {
        go_back();
        s = opened();
        ram.fault = PLFX_RAM_CUT;
        ram.when = k;
        assert_int_equal(plfx_store_write(&s, tables[2], n), PLFX_E_IO);
        bytes[k] = ram.last_size;
    }
    go_back();
    return total;
}

/* Power goes at every byte of every operation of an update; then the update is made
 * again, on what the cut left. */
static void cuts(int32_t tables_before)
{
    static uint32_t bytes[64];
    uint32_t total;
    uint32_t when;
    uint32_t tear;
    uint32_t n = 0;
    uint32_t lost = 0;
    uint32_t of[2] = {0, 0};

    fresh(16);
    write_table(0);
    if (tables_before == 2) {
        write_table(1);
    }
    remember();
    total = operations(bytes);
    assert_in_range(total, 5, 63);
    for (when = 0; when < total; when++) {
        for (tear = 0; tear <= bytes[when]; tear++) {
            plfx_store s;
            int32_t k;
            go_back();
            s = opened();
            ram.fault = PLFX_RAM_CUT;
            ram.when = when;
            ram.tear = tear;
            assert_int_equal(plfx_store_write(&s, tables[2], length_of(2)), PLFX_E_IO);
            k = held();
            n++;
            of[k == 2]++;
            lost += k != 2 && k != tables_before - 1;
            write_table(2);
            assert_int_equal(held(), 2);
            assert_int_equal(ram.misused, 0);
        }
    }
    print_message("# %u operations, %u power cuts: %u old, %u new, %u tables lost\n",
                  (unsigned)total, (unsigned)n, (unsigned)of[0], (unsigned)of[1],
                  (unsigned)lost);
    print_message("# count: power cuts, %u tried, %u missed\n", (unsigned)n,
                  (unsigned)lost);
    assert_int_equal(lost, 0);
    assert_int_not_equal(of[0], 0);
    assert_int_not_equal(of[1], 0);
}

static void no_power_cut_loses_a_table(void **state)
{
    (void)state;
    cuts(1);
    cuts(2);
}

static void failing_operations_leave_the_old_table(void **state)
{
    uint32_t tried = 0;
    static const uint8_t faults[] = {PLFX_RAM_FAIL_ONCE, PLFX_RAM_FAIL_EVER};
    static uint32_t bytes[64];
    uint32_t total;
    uint32_t when;
    size_t f;

    (void)state;
    fresh(16);
    write_table(0);
    write_table(1);
    remember();
    total = operations(bytes);
    for (f = 0; f < sizeof faults; f++) {
        for (when = 0; when < total; when++) {
            plfx_store s;
            go_back();
            s = opened();
            ram.fault = faults[f];
            ram.when = when;
            assert_int_equal(plfx_store_write(&s, tables[2], length_of(2)), PLFX_E_IO);
            assert_int_not_equal(s.bad_at, PLFX_STORE_NONE);
            assert_int_equal(s.generation, 2);
            assert_memory_equal(plfx_store_table(&s), tables[1], s.length);
            if (faults[f] == PLFX_RAM_FAIL_ONCE) {
                assert_int_equal(plfx_store_write(&s, tables[2], length_of(2)),
                                 PLFX_OK);
                assert_int_equal(held(), 2);
            } else {
                assert_in_range(held(), 1, 2); /* the last sync alone may have failed */
            }
            tried++;
        }
    }
    print_message("# count: operations that failed, %u tried, 0 missed\n",
                  (unsigned)tried);
}

/* A device whose reading `when` fails, once or for ever. */
static struct reader {
    uint32_t count, when;
    int32_t ever; /* -1: sound */
    plfx_block block;
} reader;

static plfx_status read_or_fail(void *context, uint32_t at, void *data, uint32_t n)
{
    uint32_t now = reader.count++;

    if (reader.ever >= 0 &&
        (now == reader.when || (reader.ever && now > reader.when))) {
        return PLFX_E_IO;
    }
    return ram.block.read(context, at, data, n);
}

static void reads_fail(uint32_t when, int32_t ever)
{
    reader.block = ram.block;
    reader.block.read = read_or_fail;
    reader.count = 0;
    reader.when = when;
    reader.ever = ever;
}

/* Open, read, update; a store with a table never says that it has none. */
static void session(int32_t before)
{
    uint8_t back[TABLE];
    plfx_store s;
    plfx_status status = plfx_store_open(&s, &reader.block, 7);

    if (status != PLFX_OK) {
        assert_int_equal(status, PLFX_E_IO);
        return;
    }
    assert_in_range(s.slot, 0, 1);
    status = plfx_store_read(&s, back, sizeof back);
    assert_true(status == PLFX_OK || status == PLFX_E_IO);
    if (status == PLFX_OK) {
        assert_memory_equal(back, plfx_store_table(&s), s.length);
    }
    assert_true(s.fell_back || s.generation == (uint32_t)before);
    status = plfx_store_write(&s, tables[2], length_of(2));
    assert_true(status == PLFX_OK || status == PLFX_E_IO);
    if (status == PLFX_OK) {
        assert_int_equal(held(), 2);
    }
}

static void failing_reads_lose_no_table(void **state)
{
    uint32_t tried = 0;
    int32_t before;
    int32_t ever;
    uint32_t total;
    uint32_t when;

    (void)state;
    for (before = 1; before <= 2; before++) {
        fresh(16);
        write_table(0);
        if (before == 2) {
            write_table(1);
        }
        remember();
        reads_fail(0, -1);
        session(before);
        total = reader.count;
        assert_in_range(total, 12, 60);
        for (ever = 0; ever < 2; ever++) {
            for (when = 0; when < total; when++) {
                go_back();
                reads_fail(when, ever);
                session(before);
                assert_true(held() == 2 || held() == before - 1 || held() == 0);
                tried++;
            }
        }
    }
    print_message("# count: operations that failed, %u tried, 0 missed\n",
                  (unsigned)tried);
}

/* Bytes that do not read back, and erasures that did nothing, are found at once. */
static void silent_failures_are_noticed(void **state)
{
    static uint32_t bytes[64];
    uint32_t total;
    uint32_t when;
    uint32_t bit;

    (void)state;
    fresh(16);
    write_table(0);
    write_table(1);
    remember();
    total = operations(bytes);
    for (when = 0; when < total; when++) {
        uint32_t bits = bytes[when] * 8u;
        for (bit = 0; bit < bits; bit += 37) {
            plfx_store s;
            plfx_status status;
            go_back();
            s = opened();
            ram.fault = PLFX_RAM_FLIP;
            ram.when = when;
            ram.tear = bit;
            status = plfx_store_write(&s, tables[2], length_of(2));
            assert_int_equal(held(), status == PLFX_OK ? 2 : 1);
        }
        if (bytes[when] != 0u) {
            plfx_store s;
            go_back();
            s = opened();
            ram.fault = PLFX_RAM_DEAF;
            ram.when = when;
            assert_int_not_equal(plfx_store_write(&s, tables[2], length_of(2)),
                                 PLFX_OK);
            assert_int_equal(held(), 1);
        }
    }
}

/* A bit of the table in use goes over in flight: the older table takes over, named. */
static void damaged_table_gives_way_to_the_older(void **state)
{
    plfx_store s;
    uint32_t at;
    uint32_t bit;

    (void)state;
    fresh(16);
    write_table(0);
    write_table(1);
    s = opened();
    at = (uint32_t)(plfx_store_table(&s) - flash) - 32u;
    for (bit = 0; bit < 20u * 8u; bit++) {
        flash[at + bit / 8u] ^= (uint8_t)(1u << bit % 8u);
        assert_int_equal(held(), 0);
        assert_int_equal(opened().fell_back, 1);
        flash[at + bit / 8u] ^= (uint8_t)(1u << bit % 8u);
    }
    for (bit = 0; bit < s.length * 8u; bit += 11) {
        flash[at + 32u + bit / 8u] ^= (uint8_t)(1u << bit % 8u);
        assert_int_equal(held(), 0);
        flash[at + 32u + bit / 8u] ^= (uint8_t)(1u << bit % 8u);
    }
    assert_int_equal(held(), 1);
    flash[at + 40u] ^= 1;
    flash[(at + SIZE / 2u) % SIZE + 40u] ^= 1;
    assert_int_equal(held(), -1); /* both damaged: empty, not an error */
    write_table(2);
    assert_int_equal(held(), 2);
}

static void foreign_and_broken_tables_are_refused(void **state)
{
    plfx_store s;
    uint8_t other[TABLE];
    uint32_t n;

    (void)state;
    fresh(16);
    write_table(0);
    s = opened();
    plfx_ram_power(&ram);
    n = make_table(other, 1, 8);
    assert_int_equal(plfx_store_write(&s, other, n), PLFX_E_FORMAT);
    n = length_of(1);
    tables[1][100] ^= 4;
    assert_int_equal(plfx_store_write(&s, tables[1], n), PLFX_E_FORMAT);
    assert_int_equal(plfx_store_write(&s, tables[1], n - 1), PLFX_E_FORMAT);
    assert_int_equal(plfx_store_write(&s, tables[1], SIZE), PLFX_E_SIZE);
    assert_int_equal(plfx_store_write(&s, NULL, n), PLFX_E_ARG);
    assert_int_equal(plfx_store_write(NULL, other, n), PLFX_E_ARG);
    assert_int_equal(ram.count, 0); /* nothing was erased for it */
    assert_int_equal(plfx_store_read(&s, other, 10), PLFX_E_SIZE);
    s.slot = -1;
    assert_int_equal(plfx_store_read(&s, other, TABLE), PLFX_E_STATE);
    assert_null(plfx_store_table(&s));
    assert_int_equal(held(), 0);
}

static void wild_geometry_is_refused(void **state)
{
    plfx_store s;
    plfx_block b;

    (void)state;
    fresh(16);
    b = ram.block;
    b.program_size = 24;
    assert_int_equal(plfx_store_open(&s, &b, 0), PLFX_E_ARG);
    b = ram.block;
    b.size = ERASE;
    assert_int_equal(plfx_store_open(&s, &b, 0), PLFX_E_ARG);
    b = ram.block;
    b.erase_size = 100;
    assert_int_equal(plfx_store_open(&s, &b, 0), PLFX_E_ARG);
    b = ram.block;
    b.sync = NULL;
    assert_int_equal(plfx_store_open(&s, &b, 0), PLFX_E_ARG);
    ram.off = 1;
    assert_int_equal(plfx_store_open(&s, &ram.block, 0), PLFX_E_IO);
}

/* The generation goes round after 2^32 updates and the newest still wins. */
static void generations_wrap(void **state)
{
    plfx_store s;

    (void)state;
    fresh(16);
    write_table(0);
    s = opened();
    s.generation = 0xfffffffeu;
    assert_int_equal(plfx_store_write(&s, tables[1], length_of(1)), PLFX_OK);
    flash[0] ^= 1; /* the first table goes */
    assert_int_equal(held(), 1);
    write_table(2);
    assert_int_equal(opened().generation, 0);
    assert_int_equal(held(), 2);
    write_table(0);
    assert_int_equal(held(), 0);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(tables_replace_each_other),
    cmocka_unit_test(no_power_cut_loses_a_table),
    cmocka_unit_test(failing_operations_leave_the_old_table),
    cmocka_unit_test(failing_reads_lose_no_table),
    cmocka_unit_test(silent_failures_are_noticed),
    cmocka_unit_test(damaged_table_gives_way_to_the_older),
    cmocka_unit_test(foreign_and_broken_tables_are_refused),
    cmocka_unit_test(wild_geometry_is_refused),
    cmocka_unit_test(generations_wrap),
};

SUITE(tests)
