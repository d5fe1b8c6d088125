// Circles and straight lines by KDL 1.5 (Debian `liborocos-kdl-dev`), for generators-lib/tests/curve_reference.rs. Where
// `tests/benches/peers/motions` has put KDL, from the root of the repository:
//
//     kdl=target/peers/kdl/usr; lib=$(dirname $(find $kdl/lib -name liborocos-kdl.so))
//     g++ -std=c++20 -O2 -w -I$kdl/include -I$kdl/include/eigen3 tests/benches/peers/kdl_reference.cpp \
//         -o target/peers/kdl-reference -L$lib -Wl,-rpath,$PWD/$lib -l:liborocos-kdl.so.1.5
//     target/peers/kdl-reference > generators-lib/tests/reference/kdl_paths.csv
//
// Rows `kind,case,what,numbers`, of kind `circle` (`Path_Circle`) and `line` (`Path_Line`), both with
// `RotationalInterpolation_SingleAxis`: `start` and `end`, position and quaternion x y z w, of a circle the start's and the
// orientation alone that counts of the end; of a circle `about`, its centre, a point off the start's ray that says its
// plane and direction, and its angle; `length`; then `at` length, its first and second derivative, position, quaternion,
// velocity and angular velocity, acceleration and angular acceleration, all in the frame of the path.
#include <kdl/path_circle.hpp>
#include <kdl/path_line.hpp>
#include <kdl/rotational_interpolation_sa.hpp>

#include <cmath>

#include "common.hpp"

using namespace KDL;

SplitMix64 random_{15};

Vector vector(double most) {
    const double x = random_.between(-most, most), y = random_.between(-most, most);
    return Vector(x, y, random_.between(-most, most));
}

Rotation rotation(double least, double most) {
    const Vector axis = vector(1.0);
    return Rotation::Rot(axis / axis.Norm(), random_.between(least, most));
}

void numbers(const Vector& v) { std::printf(",%.17g,%.17g,%.17g", v.x(), v.y(), v.z()); }

void numbers(const Frame& frame) {
    double x, y, z, w;
    frame.M.GetQuaternion(x, y, z, w);
    numbers(frame.p);
    std::printf(",%.17g,%.17g,%.17g,%.17g", x, y, z, w);
}

void label(const char* kind, int i, const char* what) { std::printf("%s,%d,%s", kind, i, what); }

void print(const char* kind, int i, const Frame& start, const Frame& end, Path& path) {
    label(kind, i, "start");
    numbers(start);
    std::puts("");
    label(kind, i, "end");
    numbers(end);
    std::puts("");
    const double length = path.PathLength();
    label(kind, i, "length");
    std::printf(",%.17g\n", length);
    for (int k = 0; k <= 10; ++k) {
        const double s = length * k / 10.0, ds = random_.between(-2.0, 2.0), dds = random_.between(-5.0, 5.0);
        const Twist velocity = path.Vel(s, ds), acceleration = path.Acc(s, ds, dds);
        label(kind, i, "at");
        std::printf(",%.17g,%.17g,%.17g", s, ds, dds);
        numbers(path.Pos(s));
        for (const Vector& v : {velocity.vel, velocity.rot, acceleration.vel, acceleration.rot}) numbers(v);
        std::puts("");
    }
}

int main() {
    // So small a radius to weigh turns by that the length is that of the way.
    constexpr double RADIUS = 1e-6;
    std::puts("kind,case,what,numbers");
    for (int i = 0; i < 16; ++i) {
        const Frame start(rotation(0.0, 3.0), vector(1.0));
        const Vector centre = start.p + vector(0.6), to = centre + vector(0.5);
        const double angle = random_.between(0.05, 6.2);
        const Frame end(start.M * rotation(0.0, 3.0), start.p);
        Path_Circle path(start, centre, to, end.M, angle, new RotationalInterpolation_SingleAxis(), RADIUS);
        label("circle", i, "about");
        numbers(centre);
        numbers(to);
        std::printf(",%.17g\n", angle);
        print("circle", i, start, end, path);
    }
    for (int i = 0; i < 16; ++i) {
        const Frame start(rotation(0.0, 3.0), vector(1.0));
        const Frame end(start.M * rotation(0.0, 3.0), vector(1.0));
        Path_Line path(start, end, new RotationalInterpolation_SingleAxis(), RADIUS);
        print("line", i, start, end, path);
    }
}
