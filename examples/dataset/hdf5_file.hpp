#ifndef INSONIFY_DATASET_HDF5_FILE_HPP
#define INSONIFY_DATASET_HDF5_FILE_HPP

#include <insonify/core/error.hpp>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <hdf5.h>
#include <limits>
#include <string>
#include <utility>
#include <vector>
#include <zlib.h>

namespace dataset {

/// A handle of HDF5, closed where its scope ends.
class handle {
  public:
    /// @throws insonify::io_error  for an invalid id
    handle(hid_t id, herr_t (*close)(hid_t), const std::string& what) : id_{id}, close_{close} {
        if (id < 0) throw insonify::io_error{"HDF5 cannot " + what};
    }
    handle(handle&& other) noexcept : id_{std::exchange(other.id_, -1)}, close_{other.close_} {}
    handle(const handle&) = delete;
    handle& operator=(const handle&) = delete;
    handle& operator=(handle&&) = delete;
    ~handle() {
        if (id_ >= 0) close_(id_);
    }
    operator hid_t() const { return id_; }

  private:
    hid_t id_;
    herr_t (*close_)(hid_t);
};

/// HDF5 prints its own messages unless it is told not to, in each thread.
inline void keep_hdf5_quiet() { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }

/// The version of zea whose layout files have: the one with tracks and a group for the probe.
inline constexpr const char* zea_version = "0.1.8";
inline const std::string no_unit = "–";

/// What the numbers of an array are.
enum class number_type { byte, boolean, whole, real };

/// As h5py has it: an enumeration of bytes for truth values.
inline handle type_handle(number_type type) {
    if (type == number_type::boolean) {
        handle made{H5Tenum_create(H5T_STD_I8LE), H5Tclose, "make a type"};
        const std::int8_t no = 0, yes = 1;
        H5Tenum_insert(made, "FALSE", &no);
        H5Tenum_insert(made, "TRUE", &yes);
        return made;
    }
    return {H5Tcopy(type == number_type::byte    ? H5T_STD_U8LE
                    : type == number_type::whole ? H5T_STD_U32LE
                                                 : H5T_IEEE_F32LE),
            H5Tclose, "make a type"};
}

/// A piece of an array, compressed.
using packed_chunk = std::vector<unsigned char>;

/// How repetitions are sought: runs of one byte, which is twice as fast and takes a tenth more bytes of images, or any.
enum class repetitions { runs, any };

/// Compresses numbers as the filters of HDF5 do: first bytes, second bytes and so on together, then deflate, whose checksum
/// reveals damage. Any thread may do it.
template <class Number>
packed_chunk pack(const std::vector<Number>& numbers, repetitions sought = repetitions::runs) {
    const std::size_t size = numbers.size() * sizeof(Number);
    const auto* bytes = reinterpret_cast<const unsigned char*>(numbers.data());
    std::vector<unsigned char> shuffled(size);
    for (std::size_t byte = 0; byte < sizeof(Number); ++byte)
        for (std::size_t i = 0; i < numbers.size(); ++i)
            shuffled[byte * numbers.size() + i] = bytes[i * sizeof(Number) + byte];
    z_stream stream{};
    deflateInit2(&stream, 1, Z_DEFLATED, MAX_WBITS, MAX_MEM_LEVEL,
                 sought == repetitions::runs ? Z_RLE : Z_DEFAULT_STRATEGY);
    packed_chunk packed(deflateBound(&stream, static_cast<uLong>(size)));
    stream.next_in = shuffled.data();
    stream.avail_in = static_cast<uInt>(size);
    stream.next_out = packed.data();
    stream.avail_out = static_cast<uInt>(packed.size());
    const int done = deflate(&stream, Z_FINISH);
    packed.resize(stream.total_out);
    deflateEnd(&stream);
    if (done != Z_STREAM_END) throw insonify::io_error{"zlib cannot compress a row of an array"};
    return packed;
}

/// The place of an array in a file, and its meaning.
struct array_name {
    std::string path;
    std::string unit; ///< "\u2013" where it has none
    std::string description;
};

/// Points of the probe's frame, rows x columns x 3, a chunk for each axis: rows repeat, and are compressed to almost nothing.
/// @param point  point(row, column)
template <class Point>
std::vector<packed_chunk> pack_points(hsize_t rows, hsize_t columns, const Point& point) {
    std::vector<packed_chunk> axes;
    std::vector<float> values(rows * columns);
    for (int axis = 0; axis < 3; ++axis) {
        for (hsize_t row = 0; row < rows; ++row)
            for (hsize_t column = 0; column < columns; ++column)
                values[row * columns + column] = point(row, column)[axis];
        axes.push_back(pack(values, repetitions::any));
    }
    return axes;
}

/// The group of a map, and what the last axis of its values is; empty: it is one of space.
struct map_name {
    array_name group;
    std::vector<std::string> labels{};
};

/// A file that is being made, in memory: a full disk is met by `write_file`, and not inside HDF5, which cannot close a file
/// that it cannot write. The same content gives the same bytes: no times are stored.
class hdf5_file {
  public:
    hdf5_file() : file_{create()} {}

    /// The bytes of the file.
    std::string image() const {
        check(H5Fflush(file_, H5F_SCOPE_GLOBAL));
        const ssize_t size = H5Fget_file_image(file_, nullptr, 0);
        check(size < 0 ? -1 : 0);
        std::string bytes(static_cast<std::size_t>(size), '\0');
        check(H5Fget_file_image(file_, bytes.data(), bytes.size()) < 0 ? -1 : 0);
        return bytes;
    }

    void add_group(const std::string& path, const std::string& text) {
        const handle properties{H5Pcreate(H5P_GROUP_CREATE), H5Pclose, "make a file"};
        check(H5Pset_obj_track_times(properties, false));
        const handle group{H5Gcreate2(file_, path.c_str(), H5P_DEFAULT, properties, H5P_DEFAULT), H5Gclose,
                           "make a file"};
        set_text(group, "description", text);
    }
    /// Another name of what is there.
    void add_link(const std::string& path, const std::string& target) {
        check(H5Lcreate_hard(file_, target.c_str(), file_, path.c_str(), H5P_DEFAULT, H5P_DEFAULT));
    }
    /// An attribute of the whole file, or of a group.
    void set_text(const std::string& name, const std::string& text, const std::string& group = "/") {
        const handle object{H5Oopen(file_, group.c_str(), H5P_DEFAULT), H5Oclose, "make a file"};
        set_text(object, name, text);
    }

    /// An attribute that is one number or several.
    void set_numbers(const std::string& path, const std::string& name, const std::vector<double>& values) {
        const handle object{H5Oopen(file_, path.c_str(), H5P_DEFAULT), H5Oclose, "make a file"};
        const handle space =
            space_of(values.size() == 1 ? std::vector<hsize_t>{} : std::vector<hsize_t>{values.size()});
        const handle attribute{H5Acreate2(object, name.c_str(), H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT),
                               H5Aclose, "make a file"};
        check(H5Awrite(attribute, H5T_NATIVE_DOUBLE, values.data()));
    }

    /// Texts: one, or an array.
    void add_text(const array_name& name, const std::string& text) { add_texts(name, {text}, {}); }
    void add_texts(const array_name& name, const std::vector<std::string>& texts, const std::vector<hsize_t>& shape) {
        std::vector<const char*> letters;
        for (const std::string& text : texts) letters.push_back(text.c_str());
        const handle type = text_type();
        const handle array = create_array(name, type, space_of(shape), properties());
        check(H5Dwrite(array, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, letters.data()));
    }
    /// What is said of a map beside its values and coordinates.
    void add_map(const map_name& map) {
        const auto& [path, unit, description] = map.group;
        add_group(path, description);
        add_text({path + "/unit", no_unit, "of the values"}, unit);
        add_text({path + "/description", no_unit, "of the values"}, description);
        if (!map.labels.empty())
            add_texts({path + "/labels", no_unit, "of the last axis of the values"}, map.labels, {map.labels.size()});
    }
    /// A number.
    void add_number(const array_name& name, float value) {
        const handle type = type_handle(number_type::real);
        const handle array = create_array(name, type, space_of({}), properties());
        check(H5Dwrite(array, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, &value));
    }
    /// An array of numbers, with a checksum.
    void add_array(const array_name& name, number_type numbers, const std::vector<hsize_t>& shape, const void* values) {
        const handle type = type_handle(numbers), how = properties();
        check(H5Pset_chunk(how, static_cast<int>(shape.size()), shape.data()));
        check(H5Pset_fletcher32(how));
        const handle array = create_array(name, type, space_of(shape), how);
        check(H5Dwrite(array, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values));
    }
    /// An array of numbers that is written in pieces, each with a checksum.
    class piecewise_array {
      public:
        /// @param first, second  place of the piece on the first two axes; it is whole on the others
        void write(hsize_t first, hsize_t second, const std::vector<float>& values) const {
            const handle space{H5Dget_space(array_), H5Sclose, "make a file"};
            std::vector<hsize_t> start(shape_.size(), 0), count = shape_;
            start[0] = first;
            start[1] = second;
            count[0] = count[1] = 1;
            check(H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr));
            const handle memory = space_of(count);
            check(H5Dwrite(array_, H5T_NATIVE_FLOAT, memory, space, H5P_DEFAULT, values.data()));
        }

      private:
        friend hdf5_file;
        piecewise_array(handle array, const std::vector<hsize_t>& shape) : array_{std::move(array)}, shape_{shape} {}

        handle array_;
        std::vector<hsize_t> shape_;
    };
    piecewise_array add_pieces(const array_name& name, const std::vector<hsize_t>& shape) {
        std::vector<hsize_t> chunk = shape;
        chunk[0] = chunk[1] = 1;
        const handle how = properties();
        check(H5Pset_chunk(how, static_cast<int>(chunk.size()), chunk.data()));
        check(H5Pset_fletcher32(how));
        return {create_array(name, type_handle(number_type::real), space_of(shape), how), shape};
    }
    /// An array of packed chunks, one or several for each row.
    /// @param chunk   shape of one
    /// @param pieces  returns the chunks of a row, which differ in their place on the last axis; an empty one is 0
    template <class Pieces>
    void add_packed(const array_name& name, number_type numbers, const std::vector<hsize_t>& shape,
                    const std::vector<hsize_t>& chunk, const Pieces& pieces) {
        const handle how = properties();
        check(H5Pset_chunk(how, static_cast<int>(chunk.size()), chunk.data()));
        check(H5Pset_shuffle(how));
        check(H5Pset_deflate(how, 1));
        const handle array = create_array(name, type_handle(numbers), space_of(shape), how);
        std::vector<hsize_t> start(shape.size(), 0);
        for (; start[0] < shape[0]; ++start[0]) {
            start.back() = 0;
            for (const packed_chunk& packed : pieces(start[0])) {
                if (!packed.empty())
                    check(H5Dwrite_chunk(array, H5P_DEFAULT, 0, start.data(), packed.size(), packed.data()));
                start.back() += chunk.back();
            }
        }
    }

    /// An array whose rows are those of arrays of the same name in other files, one after the other. Rows of files that are
    /// not there, or cannot be opened, have the value `missing`.
    struct source {
        std::string file; ///< relative to this one
        hsize_t rows = 0;
    };
    void add_virtual(const array_name& name, number_type numbers, std::vector<hsize_t> shape,
                     const std::vector<source>& sources, double missing) {
        const handle how = properties(), whole = space_of(shape), type = type_handle(numbers);
        if (numbers != number_type::boolean) check(H5Pset_fill_value(how, H5T_NATIVE_DOUBLE, &missing));
        std::vector<hsize_t> start(shape.size(), 0), part = shape;
        for (const source& each : sources) {
            part[0] = each.rows;
            const handle rows = space_of(part);
            const handle place{H5Scopy(whole), H5Sclose, "make a file"};
            check(H5Sselect_hyperslab(place, H5S_SELECT_SET, start.data(), nullptr, part.data(), nullptr));
            check(H5Pset_virtual(how, place, each.file.c_str(), name.path.c_str(), rows));
            start[0] += each.rows;
        }
        create_array(name, type, whole, how);
    }

  private:
    static void check(herr_t result) {
        if (result < 0) throw insonify::io_error{"HDF5 cannot make a file; is there enough memory?"};
    }
    static handle create() {
        keep_hdf5_quiet();
        const handle access{H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "make a file"};
        check(H5Pset_fapl_core(access, std::size_t{1} << 22U, false));
        return {H5Fcreate("in memory", H5F_ACC_TRUNC, H5P_DEFAULT, access), H5Fclose, "make a file"};
    }
    static handle properties() {
        handle made{H5Pcreate(H5P_DATASET_CREATE), H5Pclose, "make a file"};
        check(H5Pset_obj_track_times(made, false));
        return made;
    }
    static handle space_of(const std::vector<hsize_t>& shape) {
        return {shape.empty() ? H5Screate(H5S_SCALAR)
                              : H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr),
                H5Sclose, "make a file"};
    }
    static handle text_type() {
        handle type{H5Tcopy(H5T_C_S1), H5Tclose, "make a file"};
        check(H5Tset_size(type, H5T_VARIABLE));
        check(H5Tset_cset(type, H5T_CSET_UTF8));
        return type;
    }
    handle create_array(const array_name& name, hid_t type, hid_t space, hid_t how) const {
        handle array{H5Dcreate2(file_, name.path.c_str(), type, space, H5P_DEFAULT, how, H5P_DEFAULT), H5Dclose,
                     "make a file"};
        set_text(array, "unit", name.unit);
        set_text(array, "description", name.description);
        return array;
    }
    static void set_text(hid_t object, const std::string& name, const std::string& text) {
        const handle type = text_type(), space = space_of({});
        const handle attribute{H5Acreate2(object, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
                               "make a file"};
        const char* letters = text.c_str();
        check(H5Awrite(attribute, type, &letters));
    }

    handle file_;
};

/// A file that is read to be checked. What cannot be read is empty.
class hdf5_reader {
  public:
    explicit hdf5_reader(const std::string& path) {
        keep_hdf5_quiet();
        file_ = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    }
    hdf5_reader(const hdf5_reader&) = delete;
    hdf5_reader& operator=(const hdf5_reader&) = delete;
    ~hdf5_reader() {
        if (file_ >= 0) H5Fclose(file_);
    }
    bool is_open() const { return file_ >= 0; }

    /// An attribute of a group.
    std::string text(const std::string& group, const std::string& name) const {
        const hid_t attribute = H5Aopen_by_name(file_, group.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT);
        if (attribute < 0) return "";
        const handle open{attribute, H5Aclose, "read"}, type{H5Aget_type(attribute), H5Tclose, "read"};
        char* letters = nullptr;
        if (H5Tis_variable_str(type) <= 0 || H5Aread(open, type, &letters) < 0 || letters == nullptr) return "";
        std::string read{letters};
        H5free_memory(letters);
        return read;
    }
    /// One row of an array of numbers, as it is stored; empty where it cannot be read.
    template <class Number>
    std::vector<Number> row(const std::string& path, hsize_t index) const {
        const hid_t array = H5Dopen2(file_, path.c_str(), H5P_DEFAULT);
        if (array < 0) return {};
        const handle open{array, H5Dclose, "read"}, space{H5Dget_space(array), H5Sclose, "read"};
        std::vector<hsize_t> shape(static_cast<std::size_t>(H5Sget_simple_extent_ndims(space)));
        H5Sget_simple_extent_dims(space, shape.data(), nullptr);
        std::vector<hsize_t> start(shape.size(), 0);
        start[0] = index;
        shape[0] = 1;
        std::size_t count = 1;
        for (const hsize_t axis : shape) count *= axis;
        std::vector<Number> values(count);
        const handle memory{H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), H5Sclose, "read"};
        if (H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, shape.data(), nullptr) < 0 ||
            H5Dread(array, sizeof(Number) == 1 ? H5T_NATIVE_UINT8 : H5T_NATIVE_FLOAT, memory, space, H5P_DEFAULT,
                    values.data()) < 0)
            return {};
        return values;
    }
    /// The number of rows of an array; 0 where it cannot be read.
    hsize_t rows(const std::string& path) const {
        const hid_t array = H5Dopen2(file_, path.c_str(), H5P_DEFAULT);
        if (array < 0) return 0;
        const handle open{array, H5Dclose, "read"}, space{H5Dget_space(array), H5Sclose, "read"};
        std::vector<hsize_t> shape(static_cast<std::size_t>(H5Sget_simple_extent_ndims(space)));
        H5Sget_simple_extent_dims(space, shape.data(), nullptr);
        return shape.empty() ? 0 : shape[0];
    }

  private:
    hid_t file_ = -1;
};

} // namespace dataset
#endif
