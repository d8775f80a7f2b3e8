/* Start of a RISC-V image in data memory: stack, cleared .bss, main. */
#include <stdint.h>

extern uint32_t bss_begin[], bss_end[];
int main(void);
void run(void);

__asm__(".section .init\n.global start\nstart:\n"
        ".option push\n.option norelax\nla gp, __global_pointer$\n.option pop\n"
        "la sp, stack_top\ncall run\n");

void run(void)
{
    for (uint32_t *to = bss_begin; to < bss_end; to++) {
        *to = 0U;
    }
    (void)main();
    for (;;) {
    }
}
