// Plans of Ruckig (the sources of its Python package, compiled here); see README.md.
#include <ruckig/ruckig.hpp>

#include "common.hpp"

using namespace ruckig;

// As `plans` of generators-lib/benches/peers.rs draws them.
template <std::size_t N>
std::vector<InputParameter<N>> plans(double moving) {
    SplitMix64 random{7};
    std::vector<InputParameter<N>> all(POSITIONS);
    for (auto& one : all) {
        for (auto* where : {&one.current_position, &one.current_velocity, &one.current_acceleration,
                            &one.target_position, &one.target_velocity})
            for (std::size_t k = 0; k < N; ++k) {
                const bool position = where == &one.current_position || where == &one.target_position;
                const bool acceleration = where == &one.current_acceleration;
                const double size = position ? 2.0 : (acceleration ? 2.0 : 0.6) * moving;
                (*where)[k] = random.between(-size, size);
            }
        one.max_velocity.fill(1.0);
        one.max_acceleration.fill(4.0);
        one.max_jerk.fill(20.0);
    }
    return all;
}

template <std::size_t N>
void calculate(const char* name, double moving) {
    auto all = plans<N>(moving);
    Ruckig<N> planner;
    Trajectory<N> trajectory;
    double sum = 0;
    for (auto& one : all) {
        planner.calculate(one, trajectory);
        sum += trajectory.get_duration();
    }
    std::printf("%s sum %.9f\n", name, sum / POSITIONS);
    time(name, 50, 200, [&](int i) {
        planner.calculate(all[i], trajectory);
        keep(trajectory);
    });
    if (N == 6 && moving > 0) {
        std::array<double, N> p, v, a;
        planner.calculate(all[0], trajectory);
        const double duration = trajectory.get_duration();
        time("at_6", 100, 2000, [&](int i) {
            trajectory.at_time(duration * (i + 0.5) / POSITIONS, p, v, a);
            keep(p);
            keep(v);
            keep(a);
        });
    }
}

// A step of 1 ms of six axes on their way, to a target that stays or that moves in every step.
void update(const char* name, double drift) {
    constexpr double DT = 1e-3;
    Ruckig<6> planner(DT);
    InputParameter<6> input;
    OutputParameter<6> output;
    const auto begin = [&] {
        planner.reset();
        input = plans<6>(0.0)[3];
        output = OutputParameter<6>();
    };
    time(name, 50, 200, [&](int i) {
        if (i == 0) begin();
        if (drift > 0)
            for (int k = 0; k < 6; ++k) input.target_position[k] += drift * (k % 2 ? -1.0 : 1.0);
        planner.update(input, output);
        output.pass_to_input(input);
        keep(output);
    });
}

int main() {
    calculate<6>("rest_6", 0.0);
    calculate<6>("random_6", 1.0);
    calculate<7>("random_7", 1.0);
    update("update_same", 0.0);
    update("update_changed", 1e-4);
}
