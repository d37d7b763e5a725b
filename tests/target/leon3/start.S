! SPDX-License-Identifier: MIT
! Enter main() on a bare LEON3 with traps off but for the fatal ones, then stop.
    .section .note.GNU-stack, "", @progbits
    .section .text.start, "ax"
    .global _start
_start:
    wr      %g0, 0xe0, %psr
    nop
    nop
    nop
    wr      %g0, 0, %wim
    nop
    nop
    nop
    set     stack_top - 96, %sp
    call    main
    nop
    wr      %g0, 0xc0, %psr
    nop
    nop
    nop
    ta      0
1:  ba      1b
    nop
