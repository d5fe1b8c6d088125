// Pattern-defeating quicksort as VAMP calls it, by the standard library: RRT-Connect and its simplification do not sort.
#pragma once

#include <algorithm>

template <typename Iterator, typename Compare>
void pdqsort(Iterator first, Iterator last, Compare compare)
{
    std::sort(first, last, compare);
}

template <typename Iterator, typename Compare>
void pdqsort_branchless(Iterator first, Iterator last, Compare compare)
{
    std::sort(first, last, compare);
}
