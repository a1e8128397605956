/* Start-up and output of the emulated Cortex-M3: qemu's semihosting, no library of its own. */
#include <stdint.h>

int main(void);
void emit(char letter);
void start(void);

extern uint32_t stack_top, data_stored, data_start, data_end, bss_start, bss_end;

/* One call to the host: the operation in r0, its argument in r1. */
static void host(uint32_t operation, const void *argument)
{
    register uint32_t r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
}

void emit(char letter)
{
    host(3, &letter); /* write one letter */
}

void start(void)
{
    const uint32_t *from = &data_stored;
    for (uint32_t *to = &data_start; to < &data_end; to++) {
        *to = *from++;
    }
    for (uint32_t *to = &bss_start; to < &bss_end; to++) {
        *to = 0;
    }
    const uint32_t ended[2] = {0x20026, (uint32_t)main()}; /* the program's own end, its value */
    host(0x20, ended);
    for (;;) {
    }
}

static void stuck(void)
{
    const uint32_t ended[2] = {0x20026, 99};
    host(0x20, ended);
    for (;;) {
    }
}

/* The first words that the processor reads: the stack, then where to go for each exception. */
typedef struct {
    const void *stack;
    void (*handlers[15])(void);
} vector_table;

extern const vector_table vectors;
__attribute__((section(".vectors"), used)) const vector_table vectors = {
    &stack_top, {start, stuck, stuck, stuck, stuck, stuck}};
