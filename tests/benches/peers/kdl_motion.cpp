// Demands of KDL's straight line and circle with a trapezoid; see README.md.
#include <kdl/path_circle.hpp>
#include <kdl/path_line.hpp>
#include <kdl/rotational_interpolation_sa.hpp>
#include <kdl/trajectory_segment.hpp>
#include <kdl/velocityprofile_trap.hpp>

#include "common.hpp"

using namespace KDL;

template <class Path>
void measure(const char* kind, Path* path) {
    auto* profile = new VelocityProfile_Trap(0.4, 1.0);
    profile->SetProfile(0, path->PathLength());
    Trajectory_Segment motion(path, profile);
    const double duration = motion.Duration();
    std::vector<double> t(POSITIONS);
    for (int i = 0; i < POSITIONS; ++i) t[i] = duration * (i + 0.5) / POSITIONS;
    Vector sum = Vector::Zero();
    for (double at : t) sum += motion.Pos(at).p;
    std::printf("%s sum %.9f %.9f %.9f\n", kind, sum.x() / POSITIONS, sum.y() / POSITIONS, sum.z() / POSITIONS);
    char name[64];
    std::snprintf(name, sizeof name, "%s pose", kind);
    time(name, 100, 2000, [&](int i) {
        Frame pose = motion.Pos(t[i]);
        keep(pose);
    });
    std::snprintf(name, sizeof name, "%s derivatives", kind);
    time(name, 100, 2000, [&](int i) {
        Frame pose = motion.Pos(t[i]);
        Twist velocity = motion.Vel(t[i]), acceleration = motion.Acc(t[i]);
        keep(pose);
        keep(velocity);
        keep(acceleration);
    });
}

int main() {
    const Frame start(Rotation::RotZ(0.3), Vector(0.8, 0.1, 0.4));
    const Frame end(Rotation::RotZ(0.3) * Rotation::RotX(0.5), Vector(1.1, -0.2, 0.6));
    measure("line", new Path_Line(start, end, new RotationalInterpolation_SingleAxis(), 0.1));
    // Three quarters of a circle of 0.2 m in a plane aslant, while the tool turns about its own x axis.
    const Vector centre(0.8, 0.1, 0.2);
    const Frame on(Rotation::RotZ(0.3), Vector(1.0, 0.1, 0.2));
    const Frame turned(Rotation::RotZ(0.3) * Rotation::RotX(0.5));
    measure("circle", new Path_Circle(on, centre, centre + Vector(0.0, 0.12, 0.16), turned.M, 1.5 * M_PI,
                                      new RotationalInterpolation_SingleAxis(), 0.1));
}
