#ifndef INSONIFY_BENCH_SUPPORT_EMBREE_PIXELS_HPP
#define INSONIFY_BENCH_SUPPORT_EMBREE_PIXELS_HPP

#include "paper_scenes.hpp"
#include <embree3/rtcore.h>
#include <algorithm>
#include <cstring>

namespace bench::paper {

/// The paper's algorithm, pixel by pixel, on Embree: from each point of the slice one ray back to the transducer, which
/// collects all crossings through a filter function, and one away from it, which looks for an interface within reach.
class embree_pixels {
  public:
    enum class rays { single, packets };
    enum class shade { intensities, crossings };

    /// @param moves  MEDIUM: built as well as can be; LOW: built fast; REFIT: refitted when it moves
    explicit embree_pixels(const std::vector<mesh>& objects, RTCBuildQuality moves = RTC_BUILD_QUALITY_MEDIUM) {
        device_ = rtcNewDevice("threads=2");
        scene_ = rtcNewScene(device_);
        const bool dynamic = moves != RTC_BUILD_QUALITY_MEDIUM;
        rtcSetSceneFlags(scene_, dynamic ? RTC_SCENE_FLAG_DYNAMIC : RTC_SCENE_FLAG_NONE);
        rtcSetSceneBuildQuality(scene_, dynamic ? RTC_BUILD_QUALITY_LOW : RTC_BUILD_QUALITY_MEDIUM);
        for (const mesh& one : objects) {
            RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
            rtcSetGeometryBuildQuality(geometry, moves);
            void* const positions = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                            sizeof(vec3), one.positions.size());
            void* const faces = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                        sizeof(uvec3), one.faces.size());
            std::memcpy(positions, one.positions.data(), one.positions.size() * sizeof(vec3));
            std::memcpy(faces, one.faces.data(), one.faces.size() * sizeof(uvec3));
            rtcCommitGeometry(geometry);
            rtcAttachGeometry(scene_, geometry);
            geometries_.push_back(geometry);
        }
        rtcCommitScene(scene_);
    }
    embree_pixels(const embree_pixels&) = delete;
    embree_pixels& operator=(const embree_pixels&) = delete;
    ~embree_pixels() {
        for (RTCGeometry geometry : geometries_) rtcReleaseGeometry(geometry);
        rtcReleaseScene(scene_);
        rtcReleaseDevice(device_);
    }

    /// The vertices of the first object, to be moved; call `update` afterwards.
    vec3* positions() {
        return static_cast<vec3*>(rtcGetGeometryBufferData(geometries_[0], RTC_BUFFER_TYPE_VERTEX, 0));
    }
    void update() {
        rtcUpdateGeometryBuffer(geometries_[0], RTC_BUFFER_TYPE_VERTEX, 0);
        rtcCommitGeometry(geometries_[0]);
        rtcCommitScene(scene_);
    }

    /// One frame, on all processors, line after line.
    void trace(rays how, shade what, std::vector<float>& pixels) const {
        const std::uint32_t samples = frame.samples;
        pixels.resize(std::size_t{probe.lines} * samples);
        exec::for_each_block(exec::par, probe.lines, 8, [&](std::size_t begin, std::size_t) {
            auto found = std::make_unique<collector>();
            for (std::uint32_t k = 0; k < samples; ++k) {
                const float depth = (static_cast<float>(k) + 0.5F) * frame.depth / static_cast<float>(samples);
                how == rays::single ? collect_single(begin, depth, *found) : collect_packet(begin, depth, *found);
                for (std::size_t i = 0; i < 8; ++i)
                    pixels[(begin + i) * samples + k] = what == shade::intensities
                                                            ? intensity(found->line[i], depth)
                                                            : static_cast<float>(found->line[i].count);
            }
        });
    }

  private:
    struct crossings {
        float distance[130]; // back to the transducer
        unsigned object[130];
        unsigned count = 0;
        bool ahead = false; // an interface within reach of r3
    };
    struct collector {
        RTCIntersectContext context{};
        crossings line[8];
    };

    static void take(const RTCFilterFunctionNArguments* arguments) {
        collector& into = *reinterpret_cast<collector*>(arguments->context);
        for (unsigned i = 0; i < arguments->N; ++i) {
            if (arguments->valid[i] == 0) continue;
            crossings& line = into.line[RTCRayN_id(arguments->ray, arguments->N, i)];
            line.distance[line.count] = RTCRayN_tfar(arguments->ray, arguments->N, i);
            line.object[line.count++] = RTCHitN_geomID(arguments->hit, arguments->N, i);
            arguments->valid[i] = 0;
        }
    }

    static vec3 point_of(std::size_t line, float depth) {
        return at.point(probe.beam(static_cast<float>(line)).origin + vec3{0, 0, depth});
    }

    void collect_single(std::size_t begin, float depth, collector& found) const {
        for (unsigned i = 0; i < 8; ++i) {
            const vec3 p = point_of(begin + i, depth);
            found.line[i].count = 0;
            rtcInitIntersectContext(&found.context);
            found.context.filter = take;
            RTCRay r2{p.x, p.y, p.z, 0, 0, 0, -1, 0, depth, ~0U, i, 0};
            rtcOccluded1(scene_, &found.context, &r2);
            rtcInitIntersectContext(&found.context);
            RTCRay r3{p.x, p.y, p.z, 0, 0, 0, 1, 0, model.reflection_length, ~0U, i, 0};
            rtcOccluded1(scene_, &found.context, &r3);
            found.line[i].ahead = r3.tfar < 0;
        }
    }

    void collect_packet(std::size_t begin, float depth, collector& found) const {
        alignas(32) static constexpr int valid[8] = {-1, -1, -1, -1, -1, -1, -1, -1};
        RTCRay8 r2{};
        for (unsigned i = 0; i < 8; ++i) {
            const vec3 p = point_of(begin + i, depth);
            found.line[i].count = 0;
            r2.org_x[i] = p.x, r2.org_y[i] = p.y, r2.org_z[i] = p.z;
            r2.dir_z[i] = -1;
            r2.tfar[i] = depth;
            r2.mask[i] = ~0U;
            r2.id[i] = i;
        }
        RTCRay8 r3 = r2;
        rtcInitIntersectContext(&found.context);
        found.context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
        found.context.filter = take;
        rtcOccluded8(valid, scene_, &found.context, &r2);
        for (unsigned i = 0; i < 8; ++i) r3.dir_z[i] = 1, r3.tfar[i] = model.reflection_length;
        found.context.filter = nullptr;
        rtcOccluded8(valid, scene_, &found.context, &r3);
        for (unsigned i = 0; i < 8; ++i) found.line[i].ahead = r3.tfar[i] < 0;
    }

    // Eqs. 1 to 6 from the transducer to the point. No two cubes of these tests overlap, so in and out take turns.
    static float intensity(crossings& found, float depth) {
        std::sort(found.distance, found.distance + found.count, [](float a, float b) { return a > b; });
        const medium media[2] = {tissue::muscle, tissue::bone};
        const float through = law2011::transmitted(media[0], media[1]), back = law2011::reflected(media[0], media[1]);
        float transmitted = 1, lost = 0, above = 0;
        for (unsigned i = 0; i < found.count; ++i) {
            const float here = depth - found.distance[i];
            lost += media[i % 2].attenuation * (here - above);
            above = here;
            transmitted *= through;
        }
        lost += media[found.count % 2].attenuation * (depth - above);
        const float absorbed = std::pow(10.0F, -lost * probe.frequency * 1e-6F / 20);
        return absorbed * transmitted + (found.ahead ? back * transmitted : 0.0F);
    }

    RTCDevice device_ = nullptr;
    RTCScene scene_ = nullptr;
    std::vector<RTCGeometry> geometries_{};
};

} // namespace bench::paper
#endif
