#include <math.h>

/* W at steering angles and sizes.
 * steering[1]: beta
 * size[2]: a, l
 * W[9]: 3 rows, 3 columns, row by row
 */
void wheel_matrix(const double steering[1], const double size[2], double W[9])
{
    const double beta = steering[0];
    const double a = size[0];
    const double t0 = (1.0/3.0)*a;
    const double t1 = t0*cos(beta);
    const double t2 = t0*sin(beta);
    W[0] = t1;
    W[1] = t1;
    W[2] = t1;
    W[3] = t2;
    W[4] = t2;
    W[5] = t2;
    W[6] = 0;
    W[7] = 0;
    W[8] = 0;
}
