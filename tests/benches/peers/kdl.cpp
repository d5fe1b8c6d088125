// KDL on the arm of ortho_parallel.urdf; see README.md.
#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainiksolverpos_lma.hpp>
#include <kdl/chainiksolverpos_nr_jl.hpp>
#include <kdl/chainiksolvervel_pinv.hpp>
#include <kdl/chainjnttojacsolver.hpp>

#include "common.hpp"

int main() {
    using namespace KDL;
    Chain chain;
    chain.addSegment(Segment(Joint(Joint::RotZ), Frame(Vector(0.1, 0, 0.615))));
    chain.addSegment(Segment(Joint(Joint::RotY), Frame(Vector(0, 0, 0.705))));
    chain.addSegment(Segment(Joint(Joint::RotY), Frame(Vector(0.3, 0, 0.135))));
    chain.addSegment(Segment(Joint(Joint::RotX), Frame(Vector(0.455, 0, 0))));
    chain.addSegment(Segment(Joint(Joint::RotY), Frame(Vector(0.085, 0, 0))));
    chain.addSegment(Segment(Joint(Joint::RotX), Frame(Rotation::RotY(M_PI / 2))));
    ChainFkSolverPos_recursive forward(chain);
    ChainJntToJacSolver jacobian(chain);

    const auto all = samples();
    std::vector<JntArray> q, near;
    std::vector<Frame> pose(all.size());
    Vector sum = Vector::Zero();
    for (std::size_t i = 0; i < all.size(); ++i) {
        q.emplace_back(6);
        near.emplace_back(6);
        for (int k = 0; k < 6; ++k) {
            q[i](k) = all[i].q[k];
            near[i](k) = all[i].near[k];
        }
        forward.JntToCart(q[i], pose[i]);
        sum += pose[i].p;
    }
    std::printf("sum %.9f %.9f %.9f\n", sum.x(), sum.y(), sum.z());

    Frame out;
    time("forward", 100, 200, [&](int i) {
        forward.JntToCart(q[i], out);
        keep(out);
    });
    Jacobian j(6);
    time("jacobian", 100, 200, [&](int i) {
        jacobian.JntToJac(q[i], j);
        keep(j);
    });
    JntArray lower(6), upper(6), found(6);
    for (int k = 0; k < 6; ++k) {
        lower(k) = LOWER[k];
        upper(k) = UPPER[k];
    }
    ChainIkSolverVel_pinv velocity(chain);
    ChainIkSolverPos_NR_JL newton(chain, lower, upper, forward, velocity, 100, 1e-6);
    int solved = 0;
    time("inverse_NR_JL_1e-6", 20, 20, [&](int i) { solved += newton.CartToJnt(near[i], pose[i], found) >= 0; });
    std::printf("solved inverse_NR_JL_1e-6 %.1f\n", solved / (20.0 * POSITIONS) * 100);
    Eigen::Matrix<double, 6, 1> weights = Eigen::Matrix<double, 6, 1>::Ones();
    ChainIkSolverPos_LMA lma(chain, weights, 1e-8);
    solved = 0;
    time("inverse_LMA_1e-8", 10, 20, [&](int i) { solved += lma.CartToJnt(near[i], pose[i], found) >= 0; });
    std::printf("solved inverse_LMA_1e-8 %.1f\n", solved / (20.0 * POSITIONS) * 100);
}
