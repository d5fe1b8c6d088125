// coal's distances of two arms, timed without Python. coal_distances.py writes what this reads, compiles and runs it.
//
// Input, as words: count of links; for each the count of its capsules, and each as ax ay az bx by bz r [m] in the frame of its link (a sphere has
// a = b); count of posture pairs; for each the poses of the links of both arms, first arm first, as x y z qx qy qz qw in the world.
//
// Prints a JSON line: time per posture pair [ns] for the least distance of every pair of links (one of each arm), in three ways of asking coal,
// and the sum of what was found, so that another program's answers can be compared.

#include <chrono>
#include <cstdio>
#include <iostream>
#include <limits>
#include <memory>
#include <vector>

#include <coal/broadphase/broadphase_dynamic_AABB_tree.h>
#include <coal/broadphase/broadphase_callbacks.h>
#include <coal/distance.h>
#include <coal/shape/geometric_shapes.h>

using coal::Transform3s;
using coal::Vec3s;

struct Shape
{
    std::shared_ptr<coal::CollisionGeometry> geometry;
    Transform3s in_link;
};

// The least distance of what a tree offers. coal's own callback (3.0.3) is not used: it keeps the last distance of two spheres, not the least.
struct Least : coal::DistanceCallBackBase
{
    coal::DistanceRequest request;
    coal::DistanceResult result;
    double least = std::numeric_limits<double>::infinity();

    bool distance(coal::CollisionObject *a, coal::CollisionObject *b, coal::CoalScalar &within) override
    {
        result.clear();
        least = std::min(least, coal::distance(a, b, request, result));
        within = least;
        return least <= 0;
    }
};

auto read() -> double
{
    double value;
    if (not(std::cin >> value))
    {
        std::fprintf(stderr, "coal_distances: the input ends too early\n");
        std::exit(1);
    }
    return value;
}

auto vector() -> Vec3s
{
    const auto x = read(), y = read(), z = read();
    return {x, y, z};
}

auto shape() -> Shape
{
    const auto a = vector(), b = vector();
    const auto radius = read();
    const auto length = (b - a).norm();
    if (length == 0)
    {
        return {std::make_shared<coal::Sphere>(radius), Transform3s(a)};
    }
    const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(Vec3s::UnitZ(), b - a);
    return {std::make_shared<coal::Capsule>(radius, length), Transform3s(turn.toRotationMatrix(), (a + b) / 2)};
}

auto now()
{
    return std::chrono::steady_clock::now();
}

int main(int, char **arguments)
{
    const int rounds = std::atoi(arguments[1]);
    std::vector<std::vector<Shape>> links(static_cast<std::size_t>(read()));
    for (auto &link : links)
    {
        link.resize(static_cast<std::size_t>(read()));
        for (auto &each : link)
        {
            each = shape();
        }
    }
    const auto n = links.size();
    std::vector<std::vector<Transform3s>> postures(static_cast<std::size_t>(read()));
    for (auto &posture : postures)
    {
        for (std::size_t i = 0; i < 2 * n; ++i)
        {
            const auto place = vector();
            const auto x = read(), y = read(), z = read(), w = read();
            posture.emplace_back(Eigen::Quaterniond(w, x, y, z).toRotationMatrix(), place);
        }
    }

    // Objects of both arms, and a tree over each link's.
    std::vector<std::vector<coal::CollisionObject>> objects(2 * n);
    std::vector<std::unique_ptr<coal::DynamicAABBTreeCollisionManager>> trees;
    coal::DynamicAABBTreeCollisionManager arms[2];
    for (std::size_t i = 0; i < 2 * n; ++i)
    {
        trees.push_back(std::make_unique<coal::DynamicAABBTreeCollisionManager>());
        for (const auto &each : links[i % n])
        {
            objects[i].emplace_back(each.geometry);
        }
        for (auto &object : objects[i])
        {
            trees[i]->registerObject(&object);
            arms[i / n].registerObject(&object);
        }
        trees[i]->setup();
    }
    arms[0].setup();
    arms[1].setup();

    const auto move = [&](const std::vector<Transform3s> &posture)
    {
        for (std::size_t i = 0; i < 2 * n; ++i)
        {
            for (std::size_t j = 0; j < objects[i].size(); ++j)
            {
                objects[i][j].setTransform(posture[i] * links[i % n][j].in_link);
                objects[i][j].computeAABB();
            }
        }
    };
    coal::DistanceRequest request;
    request.enable_signed_distance = false;
    request.enable_nearest_points = false;
    coal::DistanceResult result;

    // Every shape of one link with every one of the other.
    const auto all_shapes = [&]
    {
        double sum = 0;
        for (std::size_t a = 0; a < n; ++a)
        {
            for (std::size_t b = n; b < 2 * n; ++b)
            {
                double least = std::numeric_limits<double>::infinity();
                for (auto &one : objects[a])
                {
                    for (auto &other : objects[b])
                    {
                        result.clear();
                        least = std::min(least, coal::distance(&one, &other, request, result));
                    }
                }
                sum += std::max(least, 0.0);
            }
        }
        return sum;
    };
    // The same by the trees of the links.
    const auto link_trees = [&]
    {
        double sum = 0;
        for (auto &tree : trees)
        {
            tree->update();
        }
        for (std::size_t a = 0; a < n; ++a)
        {
            for (std::size_t b = n; b < 2 * n; ++b)
            {
                Least callback;
                callback.request = request;
                trees[a]->distance(trees[b].get(), &callback);
                sum += std::max(callback.least, 0.0);
            }
        }
        return sum;
    };
    // Only the least distance of the two arms.
    const auto arm_trees = [&]
    {
        arms[0].update();
        arms[1].update();
        Least callback;
        callback.request = request;
        arms[0].distance(&arms[1], &callback);
        return std::max(callback.least, 0.0);
    };
    const auto placing = [] { return 0.0; };

    const auto measure = [&](const char *name, const auto &ask, const char *end)
    {
        double sum = 0, best = std::numeric_limits<double>::infinity();
        for (int round = 0; round < rounds; ++round)
        {
            sum = 0;
            const auto start = now();
            for (const auto &posture : postures)
            {
                move(posture);
                sum += ask();
            }
            best = std::min(best, std::chrono::duration<double, std::nano>(now() - start).count() / postures.size());
        }
        std::printf("\"%s\": {\"ns\": %.1f, \"sum\": %.9f}%s", name, best, sum, end);
    };
    std::size_t shapes = 0;
    for (const auto &link : links)
    {
        shapes += link.size();
    }
    std::printf("{\"postures\": %zu, \"links\": %zu, \"shapes\": %zu, ", postures.size(), n, shapes);
    measure("placing", placing, ", ");
    measure("all_shapes", all_shapes, ", ");
    measure("link_trees", link_trees, ", ");
    measure("arm_trees", arm_trees, "}\n");
}
