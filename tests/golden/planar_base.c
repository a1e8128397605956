#include <math.h>

/* Mass matrix and bias of the equations of motion.
 * q[3]: x, y, psi
 * qdot[3]: xdot, ydot, psidot
 * p[4]: I_cz, m, x_bc, y_bc
 * M[9]: 3 rows, 3 columns, row by row
 * n[3]: 3 rows, 1 column, row by row
 */
void planar_base(
    const double q[3],
    const double qdot[3],
    const double p[4],
    double M[9],
    double n[3])
{
    const double psi = q[2];
    const double psidot = qdot[2];
    const double I_cz = p[0];
    const double m = p[1];
    const double x_bc = p[2];
    const double y_bc = p[3];
    const double t0 = sin(psi);
    const double t1 = cos(psi);
    const double t2 = m*(t0*x_bc + t1*y_bc);
    const double t3 = -t2;
    const double t4 = m*(-t0*y_bc + t1*x_bc);
    const double t5 = psidot*psidot;
    M[0] = m;
    M[1] = 0;
    M[2] = t3;
    M[3] = 0;
    M[4] = m;
    M[5] = t4;
    M[6] = t3;
    M[7] = t4;
    M[8] = I_cz + m*(x_bc*x_bc) + m*(y_bc*y_bc);
    n[0] = -t4*t5;
    n[1] = -t2*t5;
    n[2] = 0;
}
