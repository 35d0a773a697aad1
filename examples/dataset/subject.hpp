#ifndef INSONIFY_DATASET_SUBJECT_HPP
#define INSONIFY_DATASET_SUBJECT_HPP

#include "../anatomy/region.hpp"
#include "description.hpp"
#include "labels.hpp"
#include <algorithm>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace dataset {

using any_array = std::variant<linear_array, convex_array, phased_array>;

/// The place of the probe in a view, from which that of a sample departs.
struct standpoint {
    pose straight{};         ///< z from the probe to the centre, x along the array
    vec3 centre{0, 0, 0};    ///< around which the probe moves
    float away = 0;          ///< distance from the centre that is outside of the body
    bool faces_skin = false; ///< whether z is along the normal of the surface, or keeps its angle to it
    std::string on{};        ///< name of the object that the probe is placed on; empty: the first that it meets
};

/// What samples are drawn from: a region of the body by code, or an OBJ file.
class subject {
  public:
    subject() = default;
    subject(const subject&) = delete;
    subject& operator=(const subject&) = delete;
    virtual ~subject() = default;

    /// That of the region or of the file.
    virtual std::string name() const = 0;
    /// What is printed when it was read; empty: nothing.
    virtual std::string note() const = 0;
    /// The labels of all bodies, with the medium of the first object of each; "background" first.
    virtual const std::vector<std::pair<std::string, medium>>& structures() const = 0;
    /// The label of an object of a body.
    virtual std::string structure(const object& one) const = 0;
    /// What varies from body to body.
    virtual const std::vector<anatomy::parameter>& parameters() const = 0;
    /// Values of the parameters by a random seed.
    virtual anatomy::values drawn(std::uint64_t seed) const = 0;
    /// A body, not built: with the views that samples are of, of which there are as many in each.
    virtual anatomy::body make(const anatomy::values& values) const = 0;
    /// The views of the usual body, which stand for those of others where none has been made.
    virtual const std::vector<anatomy::view>& views() const = 0;
    bool has_view(const std::string& name) const {
        return std::any_of(views().begin(), views().end(), [&](const anatomy::view& one) { return one.name == name; });
    }
    /// The largest depth of a view in any body, metres.
    virtual float deepest(std::size_t view) const = 0;
    virtual standpoint standpoint_of(const anatomy::view& seen) const = 0;
};

} // namespace dataset
#endif
