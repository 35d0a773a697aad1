#ifndef INSONIFY_DATASET_HDF5_FILE_HPP
#define INSONIFY_DATASET_HDF5_FILE_HPP

#include <insonify/core/error.hpp>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <hdf5.h>
#include <string>
#include <utility>
#include <vector>
#include <zlib.h>

namespace dataset {

/// A handle of HDF5, closed where its scope ends.
class handle {
  public:
    /// @param what  for the message, such as "write part-0003.h5"
    /// @throws insonify::io_error  for an invalid id
    handle(hid_t id, herr_t (*close)(hid_t), const std::string& what) : id_{id}, close_{close} {
        if (id < 0) throw insonify::io_error{"HDF5 cannot " + what + "; is the disk full, or the folder read-only?"};
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

inline void check(herr_t result, const std::string& what) {
    if (result < 0) throw insonify::io_error{"HDF5 cannot " + what + "; is the disk full?"};
}

template <class Number>
hid_t type_of();
template <>
inline hid_t type_of<float>() {
    return H5T_IEEE_F32LE;
}
template <>
inline hid_t type_of<std::uint8_t>() {
    return H5T_STD_U8LE;
}
template <>
inline hid_t type_of<std::uint32_t>() {
    return H5T_STD_U32LE;
}
template <>
inline hid_t type_of<std::uint64_t>() {
    return H5T_STD_U64LE;
}

/// A row of an array, compressed.
using packed_row = std::vector<unsigned char>;

/// Compresses numbers as the filters of HDF5 do: first bytes, second bytes and so on together, then deflate. Run lengths
/// alone are twice as fast as a search for longer matches, for a tenth more bytes. Any thread may do it.
template <class Number>
packed_row pack(const std::vector<Number>& numbers) {
    const std::size_t size = numbers.size() * sizeof(Number);
    const auto* bytes = reinterpret_cast<const unsigned char*>(numbers.data());
    std::vector<unsigned char> shuffled(size);
    for (std::size_t byte = 0; byte < sizeof(Number); ++byte)
        for (std::size_t i = 0; i < numbers.size(); ++i)
            shuffled[byte * numbers.size() + i] = bytes[i * sizeof(Number) + byte];
    z_stream stream{};
    deflateInit2(&stream, 1, Z_DEFLATED, MAX_WBITS, MAX_MEM_LEVEL, Z_RLE);
    packed_row packed(deflateBound(&stream, static_cast<uLong>(size)));
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

/// A file that is being written. The same content gives the same bytes: no times are stored.
class hdf5_file {
  public:
    explicit hdf5_file(const std::string& path)
        : path_{path}, file_{H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose,
                             "create " + path} {}

    /// Messages of HDF5 would go to stderr, beside the exception.
    static void keep_quiet() { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }

    /// Writes everything to the disk.
    void flush() { check(H5Fflush(file_, H5F_SCOPE_GLOBAL), "write " + path_); }

    void add_group(const std::string& name, const std::string& text) {
        const handle properties{H5Pcreate(H5P_GROUP_CREATE), H5Pclose, "write " + path_};
        check(H5Pset_obj_track_times(properties, false), "write " + path_);
        const handle group{H5Gcreate2(file_, name.c_str(), H5P_DEFAULT, properties, H5P_DEFAULT), H5Gclose,
                           "write " + path_};
        set_text(group, "description", text);
    }

    /// An attribute of the whole file.
    void set_text(const std::string& name, const std::string& text) { set_text(file_, name, text); }

    /// An array with its unit and description.
    template <class Number>
    void add(const std::string& name, const std::vector<hsize_t>& shape, const Number* values, const std::string& unit,
             const std::string& text) {
        const handle space{shape.empty() ? H5Screate(H5S_SCALAR)
                                         : H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr),
                           H5Sclose, "write " + path_};
        const handle properties{H5Pcreate(H5P_DATASET_CREATE), H5Pclose, "write " + path_};
        check(H5Pset_obj_track_times(properties, false), "write " + path_);
        const handle array{
            H5Dcreate2(file_, name.c_str(), type_of<Number>(), space, H5P_DEFAULT, properties, H5P_DEFAULT), H5Dclose,
            "write " + path_};
        check(H5Dwrite(array, type_of<Number>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values), "write " + path_);
        set_text(array, "unit", unit);
        set_text(array, "description", text);
    }
    /// A single number.
    template <class Number>
    void add(const std::string& name, Number value, const std::string& unit, const std::string& text) {
        add(name, {}, &value, unit, text);
    }
    /// An array of packed rows.
    /// @param row  returns the row of a number
    template <class Row>
    void add_packed(const std::string& name, hid_t type, const std::vector<hsize_t>& shape, const Row& row,
                    const std::string& unit, const std::string& text) {
        const handle space{H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), H5Sclose,
                           "write " + path_};
        const handle properties{H5Pcreate(H5P_DATASET_CREATE), H5Pclose, "write " + path_};
        check(H5Pset_obj_track_times(properties, false), "write " + path_);
        std::vector<hsize_t> block = shape, start(shape.size(), 0);
        block[0] = 1;
        check(H5Pset_chunk(properties, static_cast<int>(block.size()), block.data()), "write " + path_);
        check(H5Pset_shuffle(properties), "write " + path_);
        check(H5Pset_deflate(properties, 1), "write " + path_);
        const handle array{H5Dcreate2(file_, name.c_str(), type, space, H5P_DEFAULT, properties, H5P_DEFAULT), H5Dclose,
                           "write " + path_};
        for (; start[0] < shape[0]; ++start[0]) {
            const packed_row& packed = row(start[0]);
            check(H5Dwrite_chunk(array, H5P_DEFAULT, 0, start.data(), packed.size(), packed.data()), "write " + path_);
        }
        set_text(array, "unit", unit);
        set_text(array, "description", text);
    }

    /// An array whose rows are those of arrays of the same name in other files, one after the other.
    struct source {
        std::string file; ///< relative to this one
        hsize_t rows = 0;
    };
    void add_virtual(const std::string& name, hid_t type, std::vector<hsize_t> shape,
                     const std::vector<source>& sources, const std::string& unit, const std::string& text) {
        const int rank = static_cast<int>(shape.size());
        const handle properties{H5Pcreate(H5P_DATASET_CREATE), H5Pclose, "write " + path_};
        check(H5Pset_obj_track_times(properties, false), "write " + path_);
        const handle whole{H5Screate_simple(rank, shape.data(), nullptr), H5Sclose, "write " + path_};
        std::vector<hsize_t> start(shape.size(), 0), part = shape;
        for (const source& each : sources) {
            part[0] = each.rows;
            const handle rows{H5Screate_simple(rank, part.data(), nullptr), H5Sclose, "write " + path_};
            const handle place{H5Scopy(whole), H5Sclose, "write " + path_};
            check(H5Sselect_hyperslab(place, H5S_SELECT_SET, start.data(), nullptr, part.data(), nullptr),
                  "write " + path_);
            check(H5Pset_virtual(properties, place, each.file.c_str(), name.c_str(), rows), "write " + path_);
            start[0] += each.rows;
        }
        const handle array{H5Dcreate2(file_, name.c_str(), type, whole, H5P_DEFAULT, properties, H5P_DEFAULT), H5Dclose,
                           "write " + path_};
        set_text(array, "unit", unit);
        set_text(array, "description", text);
    }

  private:
    void set_text(hid_t object, const std::string& name, const std::string& text) {
        const handle type{H5Tcopy(H5T_C_S1), H5Tclose, "write " + path_};
        check(H5Tset_size(type, H5T_VARIABLE), "write " + path_);
        check(H5Tset_cset(type, H5T_CSET_UTF8), "write " + path_);
        const handle space{H5Screate(H5S_SCALAR), H5Sclose, "write " + path_};
        const handle attribute{H5Acreate2(object, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
                               "write " + path_};
        const char* letters = text.c_str();
        check(H5Awrite(attribute, type, &letters), "write " + path_);
    }

    std::string path_;
    handle file_;
};

} // namespace dataset
#endif
