#ifndef INSONIFY_BENCH_SUPPORT_EMBREE_PIXELS_HPP
#define INSONIFY_BENCH_SUPPORT_EMBREE_PIXELS_HPP

#include "embree_api.hpp"
#include "paper_scenes.hpp"
#include <algorithm>
#include <cstring>
#include <memory>

namespace bench::paper {

/// The paper's algorithm, pixel by pixel, on Embree. A ray r1 from the camera finds the point on the slice, a rectangle
/// in a scene of its own. From there r2 goes back to the transducer and meets all crossings, and r3 away from it, to see
/// whether an interface is within reach.
class embree_pixels {
  public:
    /// The paper's recursion from hit to hit, or all crossings of a ray at once through a filter function, or of eight.
    enum class rays { recursive, single, packets };
    enum class shade { intensities, crossings, none };

    /// @param moves  MEDIUM: built as well as can be; LOW: built fast; REFIT: refitted when it moves
    explicit embree_pixels(const std::vector<mesh>& objects, RTCBuildQuality moves = RTC_BUILD_QUALITY_MEDIUM) {
        device_ = rtcNewDevice("threads=2");
        scene_ = rtcNewScene(device_);
        const bool dynamic = moves != RTC_BUILD_QUALITY_MEDIUM;
        rtcSetSceneFlags(scene_, static_cast<RTCSceneFlags>(embree_filter_flag |
                                                            (dynamic ? RTC_SCENE_FLAG_DYNAMIC : RTC_SCENE_FLAG_NONE)));
        rtcSetSceneBuildQuality(scene_, dynamic ? RTC_BUILD_QUALITY_LOW : RTC_BUILD_QUALITY_MEDIUM);
        for (const mesh& one : objects) geometries_.push_back(attach(scene_, one, moves));
        rtcCommitScene(scene_);
        slice_ = rtcNewScene(device_);
        const float half = probe.width / 2;
        const mesh rectangle{{at.point({-half, 0, 0}), at.point({half, 0, 0}), at.point({half, 0, frame.depth}),
                              at.point({-half, 0, frame.depth})},
                             {{0, 1, 2}, {0, 2, 3}}};
        geometries_.push_back(attach(slice_, rectangle, RTC_BUILD_QUALITY_MEDIUM));
        rtcCommitScene(slice_);
    }
    embree_pixels(const embree_pixels&) = delete;
    embree_pixels& operator=(const embree_pixels&) = delete;
    ~embree_pixels() {
        for (RTCGeometry geometry : geometries_) rtcReleaseGeometry(geometry);
        rtcReleaseScene(scene_);
        rtcReleaseScene(slice_);
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

    /// One frame, on all processors, eight pixels of a row at a time: the columns are the lines of the probe.
    void trace(rays how, shade what, std::vector<float>& pixels) const {
        const std::uint32_t samples = frame.samples;
        pixels.resize(std::size_t{probe.lines} * samples);
        exec::for_each_block(exec::par, probe.lines, 8, 1e6F, [&](std::size_t begin, std::size_t) {
            auto found = std::make_unique<collector>(how);
            vec3 points[8];
            for (std::uint32_t k = 0; k < samples; ++k) {
                how == rays::packets ? find_points_packet(begin, k, points) : find_points_single(begin, k, points);
                if (what != shade::none)
                    how == rays::packets ? collect_packet(points, *found) : collect_single(points, *found, how);
                for (std::size_t i = 0; i < 8; ++i)
                    pixels[(begin + i) * samples + k] =
                        what == shade::intensities ? intensity(found->line[i], points[i].z)
                        : what == shade::crossings ? static_cast<float>(found->line[i].count)
                                                   : points[i].z;
            }
        });
    }

  private:
    RTCGeometry attach(RTCScene into, const mesh& one, RTCBuildQuality quality) const {
        RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
        rtcSetGeometryBuildQuality(geometry, quality);
        void* const positions = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                        sizeof(vec3), one.positions.size());
        void* const faces = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(uvec3),
                                                    one.faces.size());
        std::memcpy(positions, one.positions.data(), one.positions.size() * sizeof(vec3));
        std::memcpy(faces, one.faces.data(), one.faces.size() * sizeof(uvec3));
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(into, geometry);
        return geometry;
    }

    struct crossings {
        float distance[130]; // back to the transducer
        unsigned object[130];
        unsigned count = 0;
        bool ahead = false; // an interface within reach of r3
    };
    struct collector : embree_query {
        crossings line[8];

        explicit collector(rays how)
            : embree_query{how == rays::packets ? coherence::coherent : coherence::unknown,
                           how == rays::recursive ? nullptr : take} {}
    };

    static void take(const RTCFilterFunctionNArguments* arguments) {
        auto& into = static_cast<collector&>(embree_query::of(arguments));
        for (unsigned i = 0; i < arguments->N; ++i) {
            if (arguments->valid[i] == 0) continue;
            crossings& line = into.line[RTCRayN_id(arguments->ray, arguments->N, i)];
            line.distance[line.count] = RTCRayN_tfar(arguments->ray, arguments->N, i);
            line.object[line.count++] = RTCHitN_geomID(arguments->hit, arguments->N, i);
            arguments->valid[i] = 0;
        }
    }

    ray r1_of(std::size_t line, std::uint32_t sample) const {
        return camera_.through({static_cast<float>(line) + 0.5F, static_cast<float>(sample) + 0.5F});
    }

    void find_points_single(std::size_t begin, std::uint32_t sample, vec3 (&points)[8]) const {
        embree_query query;
        for (unsigned i = 0; i < 8; ++i) {
            ray r = r1_of(begin + i, sample);
            r.max_distance = 1;
            RTCRayHit r1 = embree_ray_hit(embree_ray(r));
            query.closest(slice_, r1);
            points[i] = r.at(r1.ray.tfar);
        }
    }
    void find_points_packet(std::size_t begin, std::uint32_t sample, vec3 (&points)[8]) const {
        embree_query query{coherence::coherent};
        RTCRayHit8 r1;
        for (unsigned i = 0; i < 8; ++i) {
            ray r = r1_of(begin + i, sample);
            r.max_distance = 1;
            set_ray_hit(r1, i, embree_ray(r));
        }
        query.closest(slice_, r1);
        for (unsigned i = 0; i < 8; ++i) points[i] = r1_of(begin + i, sample).at(r1.ray.tfar[i]);
    }

    // Back to the transducer, and away from it.
    static ray r2_of(vec3 p) { return {.origin = p, .direction = {0, 0, -1}, .max_distance = p.z}; }
    static ray r3_of(vec3 p) { return {.origin = p, .direction = {0, 0, 1}, .max_distance = model.reflection_length}; }

    void collect_single(const vec3 (&points)[8], collector& found, rays how) const {
        embree_query unfiltered;
        for (unsigned i = 0; i < 8; ++i) {
            found.line[i].count = 0;
            if (how == rays::recursive) {
                step_back(points[i], found.line[i], unfiltered);
            } else {
                RTCRay r2 = embree_ray(r2_of(points[i]), i);
                found.any(scene_, r2);
            }
            RTCRay r3 = embree_ray(r3_of(points[i]), i);
            unfiltered.any(scene_, r3);
            found.line[i].ahead = r3.tfar < 0;
        }
    }
    // r2 from hit to hit, each time from a little beyond the last.
    void step_back(vec3 p, crossings& line, embree_query& query) const {
        for (ray back = r2_of(p);;) {
            RTCRayHit r2 = embree_ray_hit(embree_ray(back));
            query.closest(scene_, r2);
            if (r2.hit.geomID == RTC_INVALID_GEOMETRY_ID || line.count == 130) return;
            line.distance[line.count] = r2.ray.tfar;
            line.object[line.count++] = r2.hit.geomID;
            back.min_distance = r2.ray.tfar + 1e-7F;
        }
    }

    void collect_packet(const vec3 (&points)[8], collector& found) const {
        embree_query unfiltered{coherence::coherent};
        RTCRay8 r2, r3;
        for (unsigned i = 0; i < 8; ++i) {
            found.line[i].count = 0;
            set_ray(r2, i, embree_ray(r2_of(points[i]), i));
            set_ray(r3, i, embree_ray(r3_of(points[i]), i));
        }
        found.any(scene_, r2);
        unfiltered.any(scene_, r3);
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
    RTCScene scene_ = nullptr, slice_ = nullptr;
    orthographic_camera camera_ = over_the_slice();
    std::vector<RTCGeometry> geometries_{};
};

} // namespace bench::paper
#endif
