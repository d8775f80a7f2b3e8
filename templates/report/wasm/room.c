/* Where the page puts arguments and finds results. */
#include <stddef.h>

double report_room[4096];

double *report_room_address(void);

double *report_room_address(void)
{
    return report_room;
}
