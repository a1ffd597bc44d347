#include "sim/objects/mesh/internal/mesh_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>
#include <limits>
#include <memory>
#include <new>
#include <string>
#include <system_error>

#include "sim/objects/errors.h"
#include "sim/objects/mesh/internal/formats/formats.h"

namespace palpate {
namespace {

struct Format {
    std::string_view extension;
    PolygonSoup (*read)(std::string_view bytes);
};
constexpr std::array kFormats{Format{".off", read_off}, Format{".obj", read_obj}, Format{".stl", read_stl}, Format{".ply", read_ply}};

std::string extension_of(const std::filesystem::path& file) {
    std::string extension = file.extension().string();
    std::ranges::transform(extension, extension.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return extension;
}

const Format& format_of(const std::filesystem::path& file) {
    const auto* format = std::ranges::find(kFormats, extension_of(file), &Format::extension);
    if (format == kFormats.end()) throw ObjectError("unknown mesh format; use .off, .ply, .obj or .stl");
    return *format;
}

struct Contents {
    std::unique_ptr<char[]> bytes;  // NOLINT(modernize-avoid-c-arrays): a string would be filled with zeros first
    std::size_t size = 0;
};

void refuse_other_than_file(const std::filesystem::path& file) {
    std::error_code error;
    switch (std::filesystem::status(file, error).type()) {
        case std::filesystem::file_type::regular:
            return;
        case std::filesystem::file_type::not_found:
            throw ObjectError("no such file; check the path (it is taken as written)");
        case std::filesystem::file_type::directory:
            throw ObjectError("is a folder; name a file in it");
        case std::filesystem::file_type::none:
            throw ObjectError(fmt::format("cannot be read ({}); check who may read it and its folder", error.message()));
        default:
            throw ObjectError("is no file but a pipe, a socket or a device; copy what it holds to a file");
    }
}

Contents contents(const std::filesystem::path& file) {
    refuse_other_than_file(file);
    Contents result{nullptr, std::filesystem::file_size(file)};
    if (result.size == 0) throw ObjectError("the file is empty; export the mesh again");
    result.bytes = std::make_unique_for_overwrite<char[]>(result.size);  // NOLINT(modernize-avoid-c-arrays)
    std::ifstream stream(file, std::ios::binary);
    if (!stream.read(result.bytes.get(), static_cast<std::streamsize>(result.size))) {
        throw ObjectError("cannot be read; check who may read it");
    }
    return result;
}

}  // namespace

PolygonSoup read_mesh(const std::filesystem::path& file) {
    try {
        const Format& format = format_of(file);
        const Contents read = contents(file);
        PolygonSoup soup = format.read({read.bytes.get(), read.size});
        if (soup.polygons.empty()) throw ObjectError("holds no faces; export it as a surface mesh");
        if (soup.points.size() > std::numeric_limits<std::uint32_t>::max()) throw ObjectError("has more than 2^32 points; simplify it");
        return soup;
    } catch (const ObjectError& error) {
        throw ObjectError(fmt::format("{}: {}", file.string(), error.what()));
    } catch (const std::bad_alloc&) {
        throw ObjectError(fmt::format("{}: is too large for the memory of this computer; simplify the mesh", file.string()));
    }
}

}  // namespace palpate
