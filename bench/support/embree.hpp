#ifndef INSONIFY_BENCH_SUPPORT_EMBREE_HPP
#define INSONIFY_BENCH_SUPPORT_EMBREE_HPP

#include <insonify/geometry/hit.hpp>
#include <insonify/geometry/mesh.hpp>
#include <insonify/geometry/ray.hpp>
#include <algorithm>
#include <cstring>
#include <embree3/rtcore.h>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace bench {

using namespace insonify;

/// Packets of N rays, and what is asked with them.
template <std::size_t N>
struct embree_packet;
template <>
struct embree_packet<8> : RTCRayHit8 {
    static constexpr auto intersect = rtcIntersect8;
    static constexpr auto occluded = rtcOccluded8;
};
template <>
struct embree_packet<16> : RTCRayHit16 {
    static constexpr auto intersect = rtcIntersect16;
    static constexpr auto occluded = rtcOccluded16;
};

/// Rays as Embree takes them, converted outside of what is measured.
struct embree_rays {
    std::vector<RTCRayHit> single{};
    std::vector<embree_packet<8>> eight{};
    std::vector<embree_packet<16>> sixteen{};

    explicit embree_rays(std::span<const ray> rays)
        : single(rays.size()), eight(rays.size() / 8), sixteen(rays.size() / 16) {
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const ray& r = rays[i];
            RTCRayHit& one = single[i];
            one.ray = {r.origin.x,
                       r.origin.y,
                       r.origin.z,
                       r.min_distance,
                       r.direction.x,
                       r.direction.y,
                       r.direction.z,
                       0,
                       r.max_distance < FLT_MAX ? r.max_distance : std::numeric_limits<float>::infinity(),
                       ~0U,
                       static_cast<unsigned>(i),
                       0};
            one.hit = {0, 0, 0, 0, 0, RTC_INVALID_GEOMETRY_ID, RTC_INVALID_GEOMETRY_ID, {RTC_INVALID_GEOMETRY_ID}};
            put(eight, i, one.ray);
            put(sixteen, i, one.ray);
        }
    }

    template <std::size_t N>
    const std::vector<embree_packet<N>>& packets() const {
        if constexpr (N == 8)
            return eight;
        else
            return sixteen;
    }

  private:
    template <std::size_t N>
    static void put(std::vector<embree_packet<N>>& packets, std::size_t i, const RTCRay& one) {
        if (i / N >= packets.size()) return;
        embree_packet<N>& packet = packets[i / N];
        const std::size_t k = i % N;
        packet.ray.org_x[k] = one.org_x;
        packet.ray.org_y[k] = one.org_y;
        packet.ray.org_z[k] = one.org_z;
        packet.ray.tnear[k] = one.tnear;
        packet.ray.dir_x[k] = one.dir_x;
        packet.ray.dir_y[k] = one.dir_y;
        packet.ray.dir_z[k] = one.dir_z;
        packet.ray.time[k] = 0;
        packet.ray.tfar[k] = one.tfar;
        packet.ray.mask[k] = ~0U;
        packet.ray.id[k] = one.id;
        packet.ray.flags[k] = 0;
        packet.hit.primID[k] = RTC_INVALID_GEOMETRY_ID;
        packet.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
        packet.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
    }
};

/// How Embree keeps a mesh.
struct embree_settings {
    RTCBuildQuality quality = RTC_BUILD_QUALITY_MEDIUM;
    RTCSceneFlags flags = RTC_SCENE_FLAG_NONE;
    unsigned threads =
        1; ///< of the device; Embree takes the highest among all devices alive, so keep one number at a time
};

/// A mesh in a scene of Embree's, on a device of its own.
class embree_peer {
  public:
    explicit embree_peer(const mesh& m, const embree_settings& settings = {}) : settings_{settings} {
        device_ = rtcNewDevice(("threads=" + std::to_string(settings.threads)).c_str());
        if (device_ == nullptr) throw std::runtime_error{"embree: no device"};
        make_scene(m);
    }
    embree_peer(const embree_peer&) = delete;
    embree_peer& operator=(const embree_peer&) = delete;
    ~embree_peer() {
        drop_scene();
        rtcReleaseDevice(device_);
    }

    /// The mesh anew, as a user would who has not built it before.
    void build(const mesh& m) {
        drop_scene();
        make_scene(m);
    }

    /// What a moving scene asks for each frame: rebuilt with the geometry's quality, or refitted, as the settings say.
    void update() {
        rtcUpdateGeometryBuffer(geometry_, RTC_BUFFER_TYPE_VERTEX, 0);
        rtcCommitGeometry(geometry_);
        rtcCommitScene(scene_);
    }

    vec3* positions() { return static_cast<vec3*>(rtcGetGeometryBufferData(geometry_, RTC_BUFFER_TYPE_VERTEX, 0)); }

    void closest(const embree_rays& rays, std::span<hit> hits) const {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        for (std::size_t i = 0; i < rays.single.size(); ++i) {
            RTCRayHit one = rays.single[i];
            rtcIntersect1(scene_, &context, &one);
            hits[i] = one.hit.geomID == RTC_INVALID_GEOMETRY_ID ? hit{} : hit{one.ray.tfar, one.hit.primID};
        }
    }

    template <std::size_t N>
    void closest_packets(const embree_rays& rays, std::span<hit> hits, RTCIntersectContextFlags flags) const {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        context.flags = flags;
        const auto& packets = rays.packets<N>();
        for (std::size_t i = 0; i < packets.size(); ++i) {
            embree_packet<N> packet = packets[i];
            embree_packet<N>::intersect(every_ray, scene_, &context, &packet);
            for (std::size_t k = 0; k < N; ++k)
                hits[N * i + k] = packet.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID
                                      ? hit{}
                                      : hit{packet.ray.tfar[k], packet.hit.primID[k]};
        }
    }

    void any(const embree_rays& rays, std::span<std::uint8_t> met) const {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        for (std::size_t i = 0; i < rays.single.size(); ++i) {
            RTCRay one = rays.single[i].ray;
            rtcOccluded1(scene_, &context, &one);
            met[i] = one.tfar < 0;
        }
    }

    template <std::size_t N>
    void any_packets(const embree_rays& rays, std::span<std::uint8_t> met, RTCIntersectContextFlags flags) const {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        context.flags = flags;
        const auto& packets = rays.packets<N>();
        for (std::size_t i = 0; i < packets.size(); ++i) {
            auto packet = packets[i].ray;
            embree_packet<N>::occluded(every_ray, scene_, &context, &packet);
            for (std::size_t k = 0; k < N; ++k) met[N * i + k] = packet.tfar[k] < 0;
        }
    }

    /// All crossings of each ray, sorted, through a filter function that takes a hit down and lets the ray go on.
    void all(const embree_rays& rays, std::span<std::vector<hit>> hits) const {
        collector all_hits{.hits = hits.data()};
        rtcInitIntersectContext(&all_hits.context);
        all_hits.context.filter = collect;
        for (std::size_t i = 0; i < rays.single.size(); ++i) {
            hits[i].clear();
            RTCRayHit one = rays.single[i];
            rtcIntersect1(scene_, &all_hits.context, &one);
            std::sort(hits[i].begin(), hits[i].end(), nearer);
        }
    }

    /// The same, N rays at a time.
    template <std::size_t N>
    void all_packets(const embree_rays& rays, std::span<std::vector<hit>> hits, RTCIntersectContextFlags flags) const {
        collector all_hits{.hits = hits.data()};
        rtcInitIntersectContext(&all_hits.context);
        all_hits.context.filter = collect;
        all_hits.context.flags = flags;
        const auto& packets = rays.packets<N>();
        for (std::size_t i = 0; i < packets.size(); ++i) {
            for (std::size_t k = 0; k < N; ++k) hits[N * i + k].clear();
            embree_packet<N> packet = packets[i];
            embree_packet<N>::intersect(every_ray, scene_, &all_hits.context, &packet);
            for (std::size_t k = 0; k < N; ++k) std::sort(hits[N * i + k].begin(), hits[N * i + k].end(), nearer);
        }
    }

    RTCScene scene() const { return scene_; }

    /// Whether this machine has registers for packets of 16.
    bool takes_sixteen() const {
        return rtcGetDeviceProperty(device_, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED) != 0;
    }

  private:
    alignas(64) static constexpr int every_ray[16] = {-1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1};

    struct collector {
        RTCIntersectContext context{};
        std::vector<hit>* hits = nullptr;
    };

    static void collect(const RTCFilterFunctionNArguments* arguments) {
        collector& into = *reinterpret_cast<collector*>(arguments->context);
        for (unsigned i = 0; i < arguments->N; ++i) {
            if (arguments->valid[i] == 0) continue;
            into.hits[RTCRayN_id(arguments->ray, arguments->N, i)].push_back(
                {RTCRayN_tfar(arguments->ray, arguments->N, i), RTCHitN_primID(arguments->hit, arguments->N, i)});
            arguments->valid[i] = 0;
        }
    }

    void make_scene(const mesh& m) {
        scene_ = rtcNewScene(device_);
        rtcSetSceneFlags(scene_, settings_.flags);
        const bool moves = settings_.quality != RTC_BUILD_QUALITY_MEDIUM && settings_.quality != RTC_BUILD_QUALITY_HIGH;
        rtcSetSceneBuildQuality(scene_,
                                moves ? RTC_BUILD_QUALITY_LOW : settings_.quality); // refits in such scenes only
        geometry_ = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
        rtcSetGeometryBuildQuality(geometry_, settings_.quality);
        void* const positions = rtcSetNewGeometryBuffer(geometry_, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                        sizeof(vec3), m.positions.size());
        void* const faces = rtcSetNewGeometryBuffer(geometry_, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                    sizeof(uvec3), m.faces.size());
        std::memcpy(positions, m.positions.data(), m.positions.size() * sizeof(vec3));
        std::memcpy(faces, m.faces.data(), m.faces.size() * sizeof(uvec3));
        rtcCommitGeometry(geometry_);
        rtcAttachGeometry(scene_, geometry_);
        rtcCommitScene(scene_);
    }

    void drop_scene() {
        rtcReleaseGeometry(geometry_);
        rtcReleaseScene(scene_);
    }

    embree_settings settings_;
    RTCDevice device_ = nullptr;
    RTCScene scene_ = nullptr;
    RTCGeometry geometry_ = nullptr;
};

} // namespace bench
#endif
