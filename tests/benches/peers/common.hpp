// The positions and the clock that all C++ peers share; see README.md.
#pragma once
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <vector>

using Six = std::array<double, 6>;

constexpr Six LOWER{-3.1416, -1.7453, -1.0472, -3.4907, -2.0944, -6.9813};
constexpr Six UPPER{3.1416, 1.9199, 1.1345, 3.4907, 2.0944, 6.9813};
constexpr int POSITIONS = 1000;

struct SplitMix64 {
    std::uint64_t state;
    double between(double lower, double upper) {
        state += 0x9e3779b97f4a7c15ULL;
        std::uint64_t z = state;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
        return lower + (upper - lower) * (double((z ^ (z >> 31)) >> 11) / double(1ULL << 53));
    }
};

struct Sample {
    Six q, near;
};

inline std::vector<Sample> samples() {
    SplitMix64 random{2014};
    std::vector<Sample> all(POSITIONS);
    for (auto& sample : all) {
        for (int i = 0; i < 6; ++i) sample.q[i] = random.between(LOWER[i], UPPER[i]);
        for (int i = 0; i < 6; ++i) sample.near[i] = sample.q[i] + random.between(-0.01, 0.01);
    }
    return all;
}

// Prints the mean time of a call: of each window of positions in a row the least of all rounds counts. Windows of slow
// calls are shorter, so that mostly nothing else runs meanwhile.
template <class Call>
void time(const char* what, int window, int rounds, Call call) {
    std::vector<double> best(POSITIONS / window, 1e300);
    for (int round = 0; round < rounds; ++round)
        for (std::size_t k = 0; k < best.size(); ++k) {
            auto start = std::chrono::steady_clock::now();
            for (int i = int(k) * window; i < int(k + 1) * window; ++i) call(i);
            std::chrono::duration<double, std::nano> took = std::chrono::steady_clock::now() - start;
            best[k] = std::min(best[k], took.count());
        }
    double sum = 0;
    for (double least : best) sum += least;
    std::printf("%s %.1f\n", what, sum / POSITIONS);
}

template <class T>
void keep(T& value) {
    asm volatile("" : : "r"(&value) : "memory");
}
