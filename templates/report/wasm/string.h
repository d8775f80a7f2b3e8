/* For WebAssembly without a C library: copies of a constant size, which the compiler writes out. */
#ifndef REPORT_STRING_H
#define REPORT_STRING_H
#include <stddef.h>
void *memcpy(void *to, const void *from, size_t size);
#endif
