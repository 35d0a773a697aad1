#ifndef INSONIFY_BENCH_SUPPORT_EMBREE_HPP
#define INSONIFY_BENCH_SUPPORT_EMBREE_HPP

#include <insonify/geometry/mesh.hpp>
#include "embree_api.hpp"
#include <algorithm>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

namespace bench {

/// A packet of N rays.
template <std::size_t N>
using embree_packet = std::conditional_t<N == 8, RTCRayHit8, RTCRayHit16>;

/// Rays in Embree's layouts. The conversion is not part of what is measured.
struct embree_rays {
    std::vector<RTCRayHit> single{};
    std::vector<RTCRayHit8> eight{};
    std::vector<RTCRayHit16> sixteen{};

    explicit embree_rays(std::span<const ray> rays)
        : single(rays.size()), eight(rays.size() / 8), sixteen(rays.size() / 16) {
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const RTCRay one = embree_ray(rays[i], static_cast<unsigned>(i));
            single[i] = embree_ray_hit(one);
            if (i / 8 < eight.size()) set_ray_hit(eight[i / 8], i % 8, one);
            if (i / 16 < sixteen.size()) set_ray_hit(sixteen[i / 16], i % 16, one);
        }
    }

    template <std::size_t N>
    const std::vector<embree_packet<N>>& packets() const {
        if constexpr (N == 8)
            return eight;
        else
            return sixteen;
    }
};

/// How Embree builds a scene.
struct embree_settings {
    RTCBuildQuality quality = RTC_BUILD_QUALITY_MEDIUM;
    RTCSceneFlags flags = RTC_SCENE_FLAG_NONE;
    /// Of the device. Embree uses the highest number of all devices that exist: use one number at a time.
    unsigned threads = 1;
};

/// A mesh in an Embree scene, on its own device.
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

    /// Builds a new scene from the mesh.
    void build(const mesh& m) {
        drop_scene();
        make_scene(m);
    }

    /// What a dynamic scene needs each frame: a rebuild with the geometry's quality, or a refit, as the settings say.
    void update() {
        rtcUpdateGeometryBuffer(geometry_, RTC_BUFFER_TYPE_VERTEX, 0);
        rtcCommitGeometry(geometry_);
        rtcCommitScene(scene_);
    }

    vec3* positions() { return static_cast<vec3*>(rtcGetGeometryBufferData(geometry_, RTC_BUFFER_TYPE_VERTEX, 0)); }

    void closest(const embree_rays& rays, std::span<hit> hits) const {
        embree_query query;
        for (std::size_t i = 0; i < rays.single.size(); ++i) {
            RTCRayHit one = rays.single[i];
            query.closest(scene_, one);
            hits[i] = one.hit.geomID == RTC_INVALID_GEOMETRY_ID ? hit{} : hit{one.ray.tfar, one.hit.primID};
        }
    }

    template <std::size_t N>
    void closest_packets(const embree_rays& rays, std::span<hit> hits, coherence kind) const {
        embree_query query{kind};
        const auto& packets = rays.packets<N>();
        for (std::size_t i = 0; i < packets.size(); ++i) {
            embree_packet<N> packet = packets[i];
            query.closest(scene_, packet);
            for (std::size_t k = 0; k < N; ++k)
                hits[N * i + k] = packet.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID
                                      ? hit{}
                                      : hit{packet.ray.tfar[k], packet.hit.primID[k]};
        }
    }

    void any(const embree_rays& rays, std::span<std::uint8_t> met) const {
        embree_query query;
        for (std::size_t i = 0; i < rays.single.size(); ++i) {
            RTCRay one = rays.single[i].ray;
            query.any(scene_, one);
            met[i] = one.tfar < 0;
        }
    }

    template <std::size_t N>
    void any_packets(const embree_rays& rays, std::span<std::uint8_t> met, coherence kind) const {
        embree_query query{kind};
        const auto& packets = rays.packets<N>();
        for (std::size_t i = 0; i < packets.size(); ++i) {
            auto packet = packets[i].ray;
            query.any(scene_, packet);
            for (std::size_t k = 0; k < N; ++k) met[N * i + k] = packet.tfar[k] < 0;
        }
    }

    /// All crossings of each ray, sorted. The filter function records each hit and rejects it.
    void all(const embree_rays& rays, std::span<std::vector<hit>> hits) const {
        collector query{coherence::unknown, hits.data()};
        for (std::size_t i = 0; i < rays.single.size(); ++i) {
            hits[i].clear();
            RTCRayHit one = rays.single[i];
            query.closest(scene_, one);
            std::sort(hits[i].begin(), hits[i].end(), nearer);
        }
    }

    /// The same, N rays at a time.
    template <std::size_t N>
    void all_packets(const embree_rays& rays, std::span<std::vector<hit>> hits, coherence kind) const {
        collector query{kind, hits.data()};
        const auto& packets = rays.packets<N>();
        for (std::size_t i = 0; i < packets.size(); ++i) {
            for (std::size_t k = 0; k < N; ++k) hits[N * i + k].clear();
            embree_packet<N> packet = packets[i];
            query.closest(scene_, packet);
            for (std::size_t k = 0; k < N; ++k) std::sort(hits[N * i + k].begin(), hits[N * i + k].end(), nearer);
        }
    }

    RTCScene scene() const { return scene_; }

    /// Whether this machine supports packets of 16 natively.
    bool takes_sixteen() const {
        return rtcGetDeviceProperty(device_, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED) != 0;
    }

  private:
    struct collector : embree_query {
        std::vector<hit>* hits;

        collector(coherence kind, std::vector<hit>* into) : embree_query{kind, collect}, hits{into} {}
    };

    static void collect(const RTCFilterFunctionNArguments* arguments) {
        const auto& into = static_cast<collector&>(embree_query::of(arguments));
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
