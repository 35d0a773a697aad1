#ifndef INSONIFY_BENCH_SUPPORT_EMBREE_API_HPP
#define INSONIFY_BENCH_SUPPORT_EMBREE_API_HPP

#include <insonify/geometry/ray.hpp>
#include <limits>
#include <string>
#if INSONIFY_BENCH_EMBREE >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

/// The one file that knows how the interfaces of Embree 3 and 4 differ.
namespace bench {

using namespace insonify;

#if RTC_VERSION_MAJOR >= 4
using embree_context = RTCRayQueryContext;
/// For scenes whose queries pass a filter function.
inline constexpr RTCSceneFlags embree_filter_flag = RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS;
#else
using embree_context = RTCIntersectContext;
inline constexpr RTCSceneFlags embree_filter_flag = RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION;
#endif

/// Version and build: Debian compiles Embree 3.13 without NDEBUG, which leaves its assertions enabled.
inline std::string embree_version() {
    return std::string{"Embree "} + RTC_VERSION_STRING +
           (INSONIFY_BENCH_EMBREE_ASSERTIONS ? " (its build has assertions enabled)" : "");
}

/// What the caller tells Embree about the rays of a packet.
enum class coherence { unknown, coherent };

/// A closest-hit or occlusion query, for one ray or a packet of 8 or 16; with a filter function where one is given.
class embree_query {
  public:
    explicit embree_query(coherence rays = coherence::unknown, RTCFilterFunctionN filter = nullptr) {
#if RTC_VERSION_MAJOR >= 4
        rtcInitRayQueryContext(&context_);
        rtcInitIntersectArguments(&closest_);
        rtcInitOccludedArguments(&any_);
        const auto flags = static_cast<RTCRayQueryFlags>(
            (rays == coherence::coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT) |
            (filter != nullptr ? RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER : 0));
        closest_.flags = any_.flags = flags;
        closest_.context = any_.context = &context_;
        closest_.filter = any_.filter = filter;
#else
        rtcInitIntersectContext(&context_);
        context_.flags =
            rays == coherence::coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
        context_.filter = filter;
#endif
    }
    embree_query(const embree_query&) = delete; // the arguments point to the context
    embree_query& operator=(const embree_query&) = delete;

    void closest(RTCScene scene, RTCRayHit& one) { run(rtcIntersect1, closest_arguments(), scene, one); }
    void closest(RTCScene scene, RTCRayHit8& packet) {
        run(rtcIntersect8, closest_arguments(), scene, packet, every_ray);
    }
    void closest(RTCScene scene, RTCRayHit16& packet) {
        run(rtcIntersect16, closest_arguments(), scene, packet, every_ray);
    }
    void any(RTCScene scene, RTCRay& one) { run(rtcOccluded1, any_arguments(), scene, one); }
    void any(RTCScene scene, RTCRay8& packet) { run(rtcOccluded8, any_arguments(), scene, packet, every_ray); }
    void any(RTCScene scene, RTCRay16& packet) { run(rtcOccluded16, any_arguments(), scene, packet, every_ray); }

    /// The query that a filter function is called for.
    static embree_query& of(const RTCFilterFunctionNArguments* arguments) {
        return *reinterpret_cast<embree_query*>(arguments->context); // the context is its first member
    }

  private:
    alignas(64) static constexpr int every_ray[16] = {-1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1};

    template <class Call, class Arguments, class Rays, class... Valid>
    static void run(Call call, Arguments& arguments, RTCScene scene, Rays& rays, const Valid&... valid) {
#if RTC_VERSION_MAJOR >= 4
        call(valid..., scene, &rays, &arguments);
#else
        call(valid..., scene, &arguments, &rays);
#endif
    }

    embree_context context_;
#if RTC_VERSION_MAJOR >= 4
    RTCIntersectArguments closest_;
    RTCOccludedArguments any_;
    RTCIntersectArguments& closest_arguments() { return closest_; }
    RTCOccludedArguments& any_arguments() { return any_; }
#else
    embree_context& closest_arguments() { return context_; }
    embree_context& any_arguments() { return context_; }
#endif
};

inline RTCRay embree_ray(const ray& r, unsigned id = 0) {
    RTCRay one{};
    one.org_x = r.origin.x, one.org_y = r.origin.y, one.org_z = r.origin.z;
    one.dir_x = r.direction.x, one.dir_y = r.direction.y, one.dir_z = r.direction.z;
    one.tnear = r.min_distance;
    one.tfar = r.max_distance < FLT_MAX ? r.max_distance : std::numeric_limits<float>::infinity();
    one.mask = ~0U;
    one.id = id;
    return one;
}

inline RTCRayHit embree_ray_hit(const RTCRay& one) {
    RTCRayHit r{};
    r.ray = one;
    r.hit.primID = r.hit.geomID = r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    return r;
}

/// Sets ray `k` of a packet.
template <class Packet>
void set_ray(Packet& packet, std::size_t k, const RTCRay& one) {
    packet.org_x[k] = one.org_x, packet.org_y[k] = one.org_y, packet.org_z[k] = one.org_z;
    packet.dir_x[k] = one.dir_x, packet.dir_y[k] = one.dir_y, packet.dir_z[k] = one.dir_z;
    packet.tnear[k] = one.tnear;
    packet.tfar[k] = one.tfar;
    packet.time[k] = one.time;
    packet.mask[k] = one.mask;
    packet.id[k] = one.id;
    packet.flags[k] = one.flags;
}
template <class Packet>
void set_ray_hit(Packet& packet, std::size_t k, const RTCRay& one) {
    set_ray(packet.ray, k, one);
    packet.hit.primID[k] = packet.hit.geomID[k] = packet.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
}

} // namespace bench
#endif
