#ifndef INSONIFY_TRACING_FIND_CUT_NORMALS_HPP
#define INSONIFY_TRACING_FIND_CUT_NORMALS_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/execution/for_each.hpp>
#include <insonify/tracing/find/slice_cut.hpp>
#include <algorithm>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// Normals at the corners of the faces that slices cut, of surfaces whose vertices have moved. Many lines meet each of these
/// faces, and none meets the others. Keeps its memory from frame to frame.
class cut_normals {
  public:
    /// Computes them and makes the scene refer to them.
    template <exec::policy Policy>
    void compute(const Policy& policy, scene_view& scene, const slice_cut& cut) {
        if (std::none_of(scene.objects.begin(), scene.objects.end(), lacks_normals)) return;
        ++frame_;
        wanted_.clear();
        objects_.assign(scene.objects.begin(), scene.objects.end());
        if (surfaces_.size() < objects_.size()) surfaces_.resize(objects_.size());
        for (std::size_t i = 0; i < objects_.size(); ++i) {
            if (!lacks_normals(objects_[i])) continue;
            surface& own = surfaces_[i];
            own.normals.resize(objects_[i].normals.ends.size());
            own.wanted_in.resize(own.normals.size());
            objects_[i].normals.normals = own.normals;
        }
        cut.for_each_segment([&](const cut_segment& segment) {
            const object_view& one = scene.objects[segment.object];
            if (segment.again || !lacks_normals(one)) return;
            const uvec3 numbers = one.normals.corners[segment.primitive];
            for (const std::uint32_t number : {numbers.x, numbers.y, numbers.z}) {
                std::uint32_t& wanted_in = surfaces_[segment.object].wanted_in[number];
                if (wanted_in != frame_) wanted_.push_back({segment.object, number});
                wanted_in = frame_;
            }
        });
        exec::for_each_block(policy, wanted_.size(), 256, 150, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const auto [object, number] = wanted_[i];
                surfaces_[object].normals[number] =
                    scene.objects[object].normals.computed(scene.objects[object].surface, number);
            }
        });
        scene.objects = objects_;
    }

  private:
    struct surface {
        std::vector<vec3> normals;            // those of this frame are valid
        std::vector<std::uint32_t> wanted_in; // the last frame in which each was
    };
    struct wanted {
        std::uint32_t object = 0, number = 0;
    };

    static bool lacks_normals(const object_view& one) {
        return one.normals.normals.empty() && !one.normals.corners.empty();
    }

    std::uint32_t frame_ = 0;
    std::vector<object_view> objects_{};
    std::vector<surface> surfaces_{}; // of each object
    std::vector<wanted> wanted_{};
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
