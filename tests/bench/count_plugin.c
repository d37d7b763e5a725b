/* SPDX-License-Identifier: MIT
 * QEMU plug-in: instructions executed, all of them and those of the symbol that the
 * argument symbol=NAME names.  With each=FILE, a line "address count" for every
 * instruction under FLASH that was executed.  Declares the few entry points that it
 * uses. */
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#define SHOWN __attribute__((visibility("default")))

typedef uint64_t plugin_id;
struct qemu_plugin_tb;
struct qemu_plugin_insn;
struct qemu_info_t;
extern void qemu_plugin_register_vcpu_tb_trans_cb(plugin_id id,
                                                  void (*f)(plugin_id,
                                                            struct qemu_plugin_tb *));
extern void qemu_plugin_register_vcpu_insn_exec_inline(struct qemu_plugin_insn *insn,
                                                       int op, void *count,
                                                       uint64_t add);
extern void qemu_plugin_register_atexit_cb(plugin_id id, void (*f)(plugin_id, void *),
                                           void *user);
extern size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb *tb);
extern struct qemu_plugin_insn *qemu_plugin_tb_get_insn(const struct qemu_plugin_tb *tb,
                                                        size_t at);
extern const char *qemu_plugin_insn_symbol(const struct qemu_plugin_insn *insn);
extern uint64_t qemu_plugin_insn_vaddr(const struct qemu_plugin_insn *insn);

SHOWN int qemu_plugin_version = 1;
int qemu_plugin_install(plugin_id id, const struct qemu_info_t *info, int argc,
                        char **argv);

#define FLASH 0x100000u

static uint64_t all, named;
static uint64_t at[FLASH / 2u]; /* instructions start at even addresses */
static char name[64];
static char each[256];

static void translated(plugin_id id, struct qemu_plugin_tb *tb)
{
    size_t n = qemu_plugin_tb_n_insns(tb);

    (void)id;
    for (size_t i = 0; i < n; i++) {
        struct qemu_plugin_insn *insn = qemu_plugin_tb_get_insn(tb, i);
        const char *symbol = qemu_plugin_insn_symbol(insn);
        uint64_t address = qemu_plugin_insn_vaddr(insn);
        qemu_plugin_register_vcpu_insn_exec_inline(insn, 0, &all, 1);
        if (symbol && strncmp(symbol, name, strlen(name)) == 0) {
            qemu_plugin_register_vcpu_insn_exec_inline(insn, 0, &named, 1);
        }
        if (each[0] && address < FLASH) {
            qemu_plugin_register_vcpu_insn_exec_inline(insn, 0, &at[address / 2u], 1);
        }
    }
}

static void write_each(void)
{
    FILE *out = fopen(each, "w");

    for (size_t i = 0; out && i < FLASH / 2u; i++) {
        if (at[i]) {
            fprintf(out, "%zx %llu\n", 2u * i, (unsigned long long)at[i]);
        }
    }
    if (!out || fclose(out)) {
        fprintf(stderr, "%s: cannot be written\n", each);
    }
}

static void ended(plugin_id id, void *user)
{
    if (each[0]) {
        write_each();
    }
    (void)id;
    (void)user;
    fprintf(stderr, "instructions %llu named %llu\n", (unsigned long long)all,
            (unsigned long long)named);
}

SHOWN int qemu_plugin_install(plugin_id id, const struct qemu_info_t *info, int argc,
                              char **argv)
{
    (void)info;
    for (int i = 0; i < argc; i++) {
        if (strncmp(argv[i], "symbol=", 7) == 0) {
            snprintf(name, sizeof name, "%s", argv[i] + 7);
        }
        if (strncmp(argv[i], "each=", 5) == 0) {
            snprintf(each, sizeof each, "%s", argv[i] + 5);
        }
    }
    qemu_plugin_register_vcpu_tb_trans_cb(id, translated);
    qemu_plugin_register_atexit_cb(id, ended, NULL);
    return 0;
}
