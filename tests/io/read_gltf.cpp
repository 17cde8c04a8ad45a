// Prints what assimp, which is independent of us, reads in a glTF file, as JSON: read_gltf FILE
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#include <iostream>
#include <nlohmann/json.hpp>

namespace {

using Json = nlohmann::json;

Json vectors(const aiVector3D* values, unsigned count) {
  Json result = Json::array();
  for (unsigned k = 0; k < count; ++k) result.push_back({values[k].x, values[k].y, values[k].z});
  return result;
}

Json meshes(const aiScene& scene) {
  Json result = Json::array();
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[m];
    Json triangles = Json::array(), targets = Json::array(), normals = Json::array();
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const unsigned* corner = mesh.mFaces[f].mIndices;
      triangles.push_back({corner[0], corner[1], corner[2]});
    }
    for (unsigned t = 0; t < mesh.mNumAnimMeshes; ++t) {
      targets.push_back(vectors(mesh.mAnimMeshes[t]->mVertices, mesh.mNumVertices));
      normals.push_back(vectors(mesh.mAnimMeshes[t]->mNormals, mesh.mNumVertices));
    }
    result.push_back({{"name", mesh.mName.C_Str()},
                      {"vertices", vectors(mesh.mVertices, mesh.mNumVertices)},
                      {"triangles", triangles},
                      {"targets", targets},
                      {"target_normals", normals}});
  }
  return result;
}

Json animation(const aiAnimation& run) {
  Json morphs = Json::array(), nodes = Json::array();
  const double to_s = run.mTicksPerSecond > 0 ? 1 / run.mTicksPerSecond : 1;
  for (unsigned c = 0; c < run.mNumMorphMeshChannels; ++c)
    for (unsigned k = 0; k < run.mMorphMeshChannels[c]->mNumKeys; ++k) {
      const aiMeshMorphKey& key = run.mMorphMeshChannels[c]->mKeys[k];
      morphs.push_back({{"time", key.mTime * to_s},
                        {"weights", std::vector<double>(key.mWeights, key.mWeights + key.mNumValuesAndWeights)}});
    }
  for (unsigned c = 0; c < run.mNumChannels; ++c) {
    const aiNodeAnim& channel = *run.mChannels[c];
    for (unsigned k = 0; channel.mNumPositionKeys > 1 && k < channel.mNumPositionKeys; ++k) {
      const aiVectorKey& at = channel.mPositionKeys[k];
      const aiQuaternion turn = channel.mRotationKeys[k].mValue;
      nodes.push_back({{"node", channel.mNodeName.C_Str()},
                       {"time", at.mTime * to_s},
                       {"position", {at.mValue.x, at.mValue.y, at.mValue.z}},
                       {"turn", {turn.x, turn.y, turn.z, turn.w}}});
    }
  }
  return {{"morphs", morphs}, {"motion", nodes}};
}

}  // namespace

int main(int argc, char** argv) {
  Assimp::Importer importer;
  const aiScene* scene = argc == 2 ? importer.ReadFile(argv[1], aiProcess_ValidateDataStructure) : nullptr;
  if (scene == nullptr || scene->mNumAnimations != 1) {
    std::cerr << "read_gltf: " << (scene ? "not one animation" : importer.GetErrorString()) << '\n';
    return 1;
  }
  const aiVector3D up = scene->mRootNode->mTransformation * aiVector3D(0, 0, 1);
  Json result = animation(*scene->mAnimations[0]);
  result["meshes"] = meshes(*scene);
  result["up"] = {up.x, up.y, up.z};
  std::cout << result << '\n';
}
