/* Start of a RISC-V image in data memory: stack, the FPU where there is one, cleared .bss, main. */
#include <stdint.h>

extern uint32_t bss_begin[], bss_end[];
int main(void);
void run(void);

__asm__(".section .init\n.global start\nstart:\n"
        ".option push\n.option norelax\nla gp, __global_pointer$\n.option pop\n"
        "la sp, stack_top\ncall run\n");

void run(void)
{
#ifdef __riscv_flen
    __asm__ volatile("csrs mstatus, %0" ::"r"(0x2000) : "memory"); /* floats may be used */
#endif
    for (uint32_t *to = bss_begin; to < bss_end; to++) {
        *to = 0U;
    }
    (void)main();
    for (;;) {
    }
}
