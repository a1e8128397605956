/* Output of the emulated AVR: its first serial port, which simavr prints. */
#include <avr/io.h>
#include <avr/interrupt.h>
#include <avr/sleep.h>

void emit(char letter);
void finish(void);

void emit(char letter)
{
    while (!(UCSR0A & (1 << UDRE0))) {
    }
    UDR0 = (uint8_t)letter;
}

/* simavr ends when the processor sleeps and nothing can wake it. */
__attribute__((noreturn)) void finish(void)
{
    while (!(UCSR0A & (1 << TXC0))) {
    }
    cli();
    for (;;) {
        sleep_mode();
    }
}
