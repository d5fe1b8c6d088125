// Nearest neighbours in the interface that VAMP takes from the library `nigh`, which no package registry has: a tree of boxes that are split in
// the middle of their longest side when they hold more than a batch of entries. Only what VAMP calls. The nearest is the same as nigh's.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace unc::robotics::nigh
{
    namespace metric
    {
        template <int p>
        struct LP
        {
        };

        template <typename Key, typename Metric>
        struct Space;
    }  // namespace metric

    struct NoThreadSafety
    {
    };

    template <std::size_t batch>
    struct KDTreeBatch
    {
        static constexpr std::size_t size = batch;
    };

    template <typename T, typename Space, typename KeyOf, typename Concurrency, typename Strategy>
    class Nigh
    {
        static constexpr int dimension = Space::kDimensions;
        using Key = typename Space::Type;

        struct Box
        {
            std::array<float, dimension> low, high;
            std::vector<T> entries;
            int axis = -1;  // of the split, -1 for a leaf
            float at = 0;
            std::size_t below = 0, above = 0;

            void grow(const Key &key)
            {
                for (int i = 0; i < dimension; ++i)
                {
                    low[i] = std::min(low[i], Space::coeff(key, i));
                    high[i] = std::max(high[i], Space::coeff(key, i));
                }
            }

            auto distance_squared(const Key &key) const -> float
            {
                float sum = 0;
                for (int i = 0; i < dimension; ++i)
                {
                    const float x = Space::coeff(key, i);
                    const float out = std::max(std::max(low[i] - x, x - high[i]), 0.F);
                    sum += out * out;
                }
                return sum;
            }
        };

        std::vector<Box> boxes;
        std::size_t count = 0;
        KeyOf key_of;

        auto leaf() -> std::size_t
        {
            Box box;
            box.low.fill(std::numeric_limits<float>::max());
            box.high.fill(std::numeric_limits<float>::lowest());
            box.entries.reserve(Strategy::size + 1);
            boxes.push_back(std::move(box));
            return boxes.size() - 1;
        }

        void split(std::size_t at)
        {
            int axis = 0;
            for (int i = 1; i < dimension; ++i)
            {
                const auto &b = boxes[at];
                axis = b.high[i] - b.low[i] > b.high[axis] - b.low[axis] ? i : axis;
            }
            if (not(boxes[at].high[axis] > boxes[at].low[axis]))
            {
                return;  // All entries are at one place.
            }
            const float middle = (boxes[at].high[axis] + boxes[at].low[axis]) / 2;
            const auto below = leaf();
            const auto above = leaf();
            for (const auto &entry : boxes[at].entries)
            {
                auto &to = boxes[Space::coeff(key_of(entry), axis) < middle ? below : above];
                to.grow(key_of(entry));
                to.entries.push_back(entry);
            }
            auto &box = boxes[at];
            box.axis = axis;
            box.at = middle;
            box.below = below;
            box.above = above;
            box.entries = {};
        }

        template <typename Visit>
        void search(std::size_t at, const Key &key, float &limit, Visit &visit) const
        {
            const auto &box = boxes[at];
            if (box.axis < 0)
            {
                for (const auto &entry : box.entries)
                {
                    visit(entry, Space::distance(key, key_of(entry)), limit);
                }
                return;
            }
            const bool is_below = Space::coeff(key, box.axis) < box.at;
            const auto next = std::array{is_below ? box.below : box.above, is_below ? box.above : box.below};
            for (const auto child : next)
            {
                if (boxes[child].distance_squared(key) <= limit * limit)
                {
                    search(child, key, limit, visit);
                }
            }
        }

    public:
        [[nodiscard]] auto size() const -> std::size_t
        {
            return count;
        }

        void insert(const T &entry)
        {
            if (boxes.empty())
            {
                leaf();
            }
            std::size_t at = 0;
            boxes[at].grow(key_of(entry));
            while (boxes[at].axis >= 0)
            {
                at = Space::coeff(key_of(entry), boxes[at].axis) < boxes[at].at ? boxes[at].below : boxes[at].above;
                boxes[at].grow(key_of(entry));
            }
            boxes[at].entries.push_back(entry);
            ++count;
            if (boxes[at].entries.size() > Strategy::size)
            {
                split(at);
            }
        }

        [[nodiscard]] auto nearest(const Key &key) const -> std::optional<std::pair<T, float>>
        {
            std::optional<std::pair<T, float>> found;
            float limit = std::numeric_limits<float>::infinity();
            const auto visit = [&found](const T &entry, float distance, float &within)
            {
                if (distance < within)
                {
                    found = std::pair{entry, distance};
                    within = distance;
                }
            };
            if (count > 0)
            {
                search(0, key, limit, visit);
            }
            return found;
        }

        void nearest(
            std::vector<std::pair<T, float>> &found,
            const Key &key,
            std::size_t most,
            float radius = std::numeric_limits<float>::infinity()) const
        {
            found.clear();
            const auto nearer = [](const auto &a, const auto &b) { return a.second < b.second; };
            float limit = radius;
            const auto visit = [&](const T &entry, float distance, float &within)
            {
                if (distance > within or most == 0)
                {
                    return;
                }
                found.emplace_back(entry, distance);
                std::push_heap(found.begin(), found.end(), nearer);
                if (found.size() > most)
                {
                    std::pop_heap(found.begin(), found.end(), nearer);
                    found.pop_back();
                }
                within = found.size() == most ? std::min(radius, found.front().second) : radius;
            };
            if (count > 0)
            {
                search(0, key, limit, visit);
            }
            std::sort_heap(found.begin(), found.end(), nearer);
        }
    };
}  // namespace unc::robotics::nigh
