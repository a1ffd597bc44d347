// The one place that knows lib3mf.
#include <fmt/format.h>
#include <lib3mf/Model/COM/NMR_DLLInterfaces.h>

#include <array>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include "tools/formats/mesh_formats.h"

namespace palpate {
namespace {

struct Release {
    void operator()(NMR::PLib3MFBase* object) const { NMR::lib3mf_release(object); }
};
template <typename Object>
using Owned = std::unique_ptr<Object, Release>;

void check(LIB3MFRESULT result, NMR::PLib3MFBase* object, const char* what) {
    if (result == 0) return;
    DWORD code = 0;
    LPCSTR text = nullptr;
    if (object != nullptr) NMR::lib3mf_getlasterror(object, &code, &text);
    throw std::runtime_error(fmt::format("3MF: {} failed: {}", what, text != nullptr ? text : "no reason given"));
}

}  // namespace

std::string to_3mf(const TriangleMesh& mesh) {
    NMR::PLib3MFModel* raw_model = nullptr;
    check(NMR::lib3mf_createmodel(&raw_model), nullptr, "a model");
    const Owned<NMR::PLib3MFModel> model(raw_model);
    NMR::PLib3MFModelMeshObject* raw_object = nullptr;
    check(NMR::lib3mf_model_addmeshobject(model.get(), &raw_object), model.get(), "a mesh");
    const Owned<NMR::PLib3MFModelMeshObject> object(raw_object);

    std::vector<NMR::MODELMESHVERTEX> points(mesh.points.size());
    for (std::size_t k = 0; k < points.size(); ++k) {
        for (int axis = 0; axis < 3; ++axis) points[k].m_fPosition[axis] = static_cast<float>(mesh.points[k][axis]);
    }
    std::vector<NMR::MODELMESHTRIANGLE> triangles(mesh.triangles.size());
    for (std::size_t k = 0; k < triangles.size(); ++k) {
        for (std::size_t corner = 0; corner < 3; ++corner) triangles[k].m_nIndices[corner] = mesh.triangles[k].at(corner);
    }
    check(NMR::lib3mf_meshobject_setgeometry(object.get(), points.data(), static_cast<DWORD>(points.size()), triangles.data(),
                                             static_cast<DWORD>(triangles.size())),
          object.get(), "the mesh's triangles");
    NMR::PLib3MFModelBuildItem* raw_item = nullptr;
    check(NMR::lib3mf_model_addbuilditem(model.get(), object.get(), nullptr, &raw_item), model.get(), "what is to be built");
    const Owned<NMR::PLib3MFModelBuildItem> item(raw_item);
    NMR::PLib3MFModelWriter* raw_writer = nullptr;
    check(NMR::lib3mf_model_querywriter(model.get(), "3mf", &raw_writer), model.get(), "a writer");
    const Owned<NMR::PLib3MFModelWriter> writer(raw_writer);
    ULONG64 size = 0;
    check(NMR::lib3mf_writer_getstreamsize(writer.get(), &size), writer.get(), "the size");
    std::string out(size, '\0');
    check(NMR::lib3mf_writer_writetobuffer(writer.get(), reinterpret_cast<BYTE*>(out.data()), size), writer.get(), "writing");
    return out;
}

}  // namespace palpate
