// Pinocchio on the arm of ortho_parallel.urdf, joint by joint as its URDF reader builds it (the wheels lack the
// headers that this reader needs); see README.md.
#include <pinocchio/algorithm/frames.hpp>
#include <pinocchio/algorithm/jacobian.hpp>
#include <pinocchio/algorithm/joint-configuration.hpp>
#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/multibody.hpp>
#include <pinocchio/spatial.hpp>

#include "common.hpp"

int main() {
    namespace pin = pinocchio;
    pin::Model model;
    const auto at = [](double x, double y, double z) {
        return pin::SE3(Eigen::Matrix3d::Identity(), Eigen::Vector3d(x, y, z));
    };
    pin::JointIndex last = 0;
    last = model.addJoint(last, pin::JointModelRZ(), at(0, 0, 0.615), "joint_1");
    last = model.addJoint(last, pin::JointModelRY(), at(0.1, 0, 0), "joint_2");
    last = model.addJoint(last, pin::JointModelRY(), at(0, 0, 0.705), "joint_3");
    last = model.addJoint(last, pin::JointModelRX(), at(0.3, 0, 0.135), "joint_4");
    last = model.addJoint(last, pin::JointModelRY(), at(0.455, 0, 0), "joint_5");
    last = model.addJoint(last, pin::JointModelRX(), at(0.085, 0, 0), "joint_6");
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitY()).toRotationMatrix();
    const auto tool = model.addFrame(
        pin::Frame("tool0", last, 0, pin::SE3(turn, Eigen::Vector3d::Zero()), pin::OP_FRAME));
    pin::Data data(model);

    const auto all = samples();
    std::vector<Eigen::VectorXd> q, near;
    std::vector<pin::SE3> pose;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const auto& sample : all) {
        q.push_back(Eigen::Map<const Eigen::VectorXd>(sample.q.data(), 6));
        near.push_back(Eigen::Map<const Eigen::VectorXd>(sample.near.data(), 6));
        pin::forwardKinematics(model, data, q.back());
        pin::updateFramePlacement(model, data, tool);
        pose.push_back(data.oMf[tool]);
        sum += pose.back().translation();
    }
    std::printf("sum %.9f %.9f %.9f\n", sum.x(), sum.y(), sum.z());

    time("forward", 100, 200, [&](int i) {
        pin::forwardKinematics(model, data, q[i]);
        pin::updateFramePlacement(model, data, tool);
        keep(data);
    });
    pin::Data::Matrix6x j(6, 6);
    j.setZero();
    time("jacobian", 100, 200, [&](int i) {
        pin::computeFrameJacobian(model, data, q[i], tool, pin::LOCAL_WORLD_ALIGNED, j);
        keep(j);
    });
    time("jacobian_by_joint_Jacobians", 100, 200, [&](int i) {
        pin::computeJointJacobians(model, data, q[i]);
        pin::getFrameJacobian(model, data, tool, pin::LOCAL_WORLD_ALIGNED, j);
        keep(j);
    });
    int solved = 0;
    Eigen::VectorXd joints(6);
    time("inverse_GaussNewton_1e-8", 100, 100, [&](int i) {
        joints = near[i];
        for (int step = 0; step < 50; ++step) {
            pin::computeJointJacobians(model, data, joints);
            pin::updateFramePlacement(model, data, tool);
            const pin::SE3 way = data.oMf[tool].actInv(pose[i]);
            const Eigen::Matrix<double, 6, 1> error = pin::log6(way).toVector();
            if (error.norm() < 1e-8) {
                ++solved;
                break;
            }
            j.setZero();
            pin::getFrameJacobian(model, data, tool, pin::LOCAL, j);
            const Eigen::Matrix<double, 6, 6> fixed = j;
            Eigen::Matrix<double, 6, 6> normal = fixed * fixed.transpose();
            normal.diagonal().array() += 1e-12;
            joints += fixed.transpose() * normal.ldlt().solve(error);
        }
        keep(joints);
    });
    std::printf("solved inverse_GaussNewton_1e-8 %.1f\n", solved / (100.0 * POSITIONS) * 100);
}
