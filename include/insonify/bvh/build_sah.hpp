#ifndef INSONIFY_BVH_BUILD_SAH_HPP
#define INSONIFY_BVH_BUILD_SAH_HPP

#include <insonify/bvh/node.hpp>
#include <insonify/core/algorithm.hpp>
#include <insonify/core/view.hpp>
#include <insonify/execution/for_each.hpp>
#include <numeric>

namespace insonify::inline INSONIFY_ABI {

/// Builds a wide tree from the top by the surface area heuristic over bins, splitting the child of largest area until a
/// node is full.
///
///     [      all      ]  ->  [   a   |   b   ]  ->  [   a   | b1 | b2 ]  ->  ...  Width children
///
/// The tree depends on the boxes alone, not on the policy. Boxes that are empty or not finite are left out.
/// Source: Wald 2007, "On fast construction of SAH-based bounding volume hierarchies"; the cost of a child is its area
/// times the number of leaves that it takes.
struct build_sah {
    static constexpr int bins = 16;

    template <int Width, exec::policy Policy>
    topology<Width> operator()(const Policy& policy, view<const aabb> boxes) const;
};

/// One build: the boxes, and the order of primitives that the splits sort.
template <int Width>
class sah_builder {
  public:
    explicit sah_builder(view<const aabb> boxes) : boxes_{boxes} {
        order_.reserve(boxes.size());
        for (std::uint32_t i = 0; i < boxes.size(); ++i)
            if (is_finite(boxes[i])) order_.push_back(i);
    }

    template <class Policy>
    topology<Width> build(const Policy& policy) {
        topology<Width> tree;
        if (order_.empty()) return tree;
        const std::size_t count = order_.size();
        std::vector<subtree> later;
        add_node(tree, {0, count, box_of(0, count)}, 1, std::max<std::size_t>(count / 64, 2048), &later);
        std::vector<topology<Width>> parts(later.size());
        for_each_index(policy, later.size(),
                       [&](std::size_t i) { add_node(parts[i], later[i].all, later[i].level, 0, nullptr); });
        for (std::size_t i = 0; i < parts.size(); ++i) append(tree, parts[i], later[i]);
        return tree;
    }

  private:
    struct group {
        std::size_t begin = 0;
        std::size_t end = 0;
        aabb box{};

        std::size_t size() const { return end - begin; }
    };

    // A part of the tree that is built by itself, and where it will hang.
    struct subtree {
        group all{};
        std::uint32_t level = 0;
        std::uint32_t parent = 0;
        std::uint32_t place = 0;
    };

    struct bin {
        aabb box{};
        std::size_t count = 0;
    };

    static float leaf_cost(std::size_t count) { return static_cast<float>((count + Width - 1) / Width); }

    // Half the centre of a box: it sorts as the centre does, and two of them never lie infinitely far apart.
    float centre(std::uint32_t primitive, int axis) const {
        return 0.25F * boxes_[primitive].lower[axis] + 0.25F * boxes_[primitive].upper[axis];
    }

    aabb box_of(std::size_t begin, std::size_t end) const {
        aabb whole;
        for (std::size_t i = begin; i < end; ++i) whole = merged(whole, boxes_[order_[i]]);
        return whole;
    }

    std::uint32_t add_node(topology<Width>& tree, const group& all, std::uint32_t level, std::size_t later_below,
                           std::vector<subtree>* later) {
        const auto node = static_cast<std::uint32_t>(tree.nodes.size());
        tree.nodes.emplace_back();
        tree.levels = std::max(tree.levels, level);
        group children[Width];
        const int count = divide(all, level, children);
        for (int i = 0; i < Width; ++i) {
            std::uint32_t code = no_child;
            if (i < count && children[i].size() <= Width)
                code = add_leaf(tree, children[i]);
            else if (i < count && later != nullptr && children[i].size() <= later_below)
                later->push_back({children[i], level + 1, node, static_cast<std::uint32_t>(i)});
            else if (i < count)
                code = add_node(tree, children[i], level + 1, later_below, later);
            tree.nodes[node].child[i] = code;
        }
        return node;
    }

    std::uint32_t add_leaf(topology<Width>& tree, const group& held) {
        const auto index = static_cast<std::uint32_t>(tree.leaves());
        tree.slots.resize(tree.slots.size() + Width, no_primitive);
        std::sort(order_.begin() + static_cast<std::ptrdiff_t>(held.begin),
                  order_.begin() + static_cast<std::ptrdiff_t>(held.end));
        for (std::size_t i = 0; i < held.size(); ++i)
            tree.slots[std::size_t{index} * Width + i] = order_[held.begin + i];
        return index | leaf_bit;
    }

    // Hangs a part under its parent; node 0 of the part takes the next free index.
    static void append(topology<Width>& tree, const topology<Width>& part, const subtree& where) {
        const auto first_node = static_cast<std::uint32_t>(tree.nodes.size());
        const auto first_leaf = static_cast<std::uint32_t>(tree.leaves());
        tree.nodes[where.parent].child[where.place] = first_node;
        for (node_children<Width> node : part.nodes) {
            for (std::uint32_t& child : node.child)
                if (child != no_child) child += (child & leaf_bit) != 0 ? first_leaf : first_node;
            tree.nodes.push_back(node);
        }
        tree.slots.insert(tree.slots.end(), part.slots.begin(), part.slots.end());
        tree.levels = std::max(tree.levels, part.levels);
    }

    int divide(const group& all, std::uint32_t level, group (&children)[Width]) {
        children[0] = all;
        int count = 1;
        while (count < Width) {
            int chosen = -1;
            float most = -1;
            for (int i = 0; i < count; ++i) {
                const float size =
                    level < free_levels ? children[i].box.half_area() : static_cast<float>(children[i].size());
                if (children[i].size() > Width && size > most) {
                    most = size;
                    chosen = i;
                }
            }
            if (chosen < 0) break;
            const group whole = children[chosen];
            const std::size_t middle = level < free_levels ? split_by_area(whole) : split_by_number(whole);
            children[chosen] = {whole.begin, middle, box_of(whole.begin, middle)};
            children[count++] = {middle, whole.end, box_of(middle, whole.end)};
        }
        return count;
    }

    aabb centres_of(const group& g) const {
        aabb whole;
        for (std::size_t i = g.begin; i < g.end; ++i) {
            const std::uint32_t p = order_[i];
            whole = merged(whole, vec3{centre(p, 0), centre(p, 1), centre(p, 2)});
        }
        return whole;
    }

    // Sorts the group into two sides of the cheapest plane between bins; returns where the second begins.
    std::size_t split_by_area(const group& g) {
        const aabb centres = centres_of(g);
        const vec3 extent = centres.size();
        vec3 scale{0, 0, 0};
        for (int axis = 0; axis < 3; ++axis)
            if (extent[axis] > 0) scale[axis] = lesser(static_cast<float>(build_sah::bins) / extent[axis], FLT_MAX);
        const auto bin_of = [&](std::uint32_t p, int axis) {
            const float place = (centre(p, axis) - centres.lower[axis]) * scale[axis];
            return static_cast<int>(lesser(place, static_cast<float>(build_sah::bins - 1)));
        };
        bin binned[3][build_sah::bins];
        for (std::size_t i = g.begin; i < g.end; ++i) {
            const std::uint32_t p = order_[i];
            for (int axis = 0; axis < 3; ++axis) {
                bin& b = binned[axis][bin_of(p, axis)];
                b.box = merged(b.box, boxes_[p]);
                ++b.count;
            }
        }
        int best_axis = -1, best_plane = 0;
        float best_cost = FLT_MAX;
        for (int axis = 0; axis < 3; ++axis) {
            float cost_above[build_sah::bins] = {};
            bin above;
            for (int k = build_sah::bins - 1; k > 0; --k) {
                above = {merged(above.box, binned[axis][k].box), above.count + binned[axis][k].count};
                cost_above[k] = above.box.half_area() * leaf_cost(above.count);
            }
            bin below;
            for (int k = 1; k < build_sah::bins; ++k) {
                below = {merged(below.box, binned[axis][k - 1].box), below.count + binned[axis][k - 1].count};
                if (below.count == 0 || below.count == g.size()) continue;
                const float cost = below.box.half_area() * leaf_cost(below.count) + cost_above[k];
                if (cost < best_cost) {
                    best_cost = cost;
                    best_axis = axis;
                    best_plane = k;
                }
            }
        }
        if (best_axis < 0) return split_by_number(g);
        const auto first = order_.begin() + static_cast<std::ptrdiff_t>(g.begin);
        const auto last = order_.begin() + static_cast<std::ptrdiff_t>(g.end);
        const auto middle =
            std::partition(first, last, [&](std::uint32_t p) { return bin_of(p, best_axis) < best_plane; });
        return static_cast<std::size_t>(middle - order_.begin());
    }

    // Halves the group along its longest side, a whole number of leaves in the first half.
    std::size_t split_by_number(const group& g) {
        const vec3 extent = centres_of(g).size();
        const int axis = extent.x > extent.y ? (extent.x > extent.z ? 0 : 2) : (extent.y > extent.z ? 1 : 2);
        const std::size_t half = (g.size() / 2 + Width - 1) / Width * Width;
        const auto first = order_.begin() + static_cast<std::ptrdiff_t>(g.begin);
        const auto last = order_.begin() + static_cast<std::ptrdiff_t>(g.end);
        std::nth_element(first, first + static_cast<std::ptrdiff_t>(half), last, [&](std::uint32_t a, std::uint32_t b) {
            const float ca = centre(a, axis), cb = centre(b, axis);
            return ca < cb || (ca == cb && a < b);
        });
        return g.begin + half;
    }

    view<const aabb> boxes_;
    std::vector<std::uint32_t> order_{};
};

template <int Width, exec::policy Policy>
topology<Width> build_sah::operator()(const Policy& policy, view<const aabb> boxes) const {
    return sah_builder<Width>{boxes}.build(policy);
}

} // namespace insonify::inline INSONIFY_ABI
#endif
