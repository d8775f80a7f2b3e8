/* The memory in which the page writes arguments and reads results. */
#include <stddef.h>

double report_buffer[4096];

double *report_buffer_address(void);

double *report_buffer_address(void)
{
    return report_buffer;
}
