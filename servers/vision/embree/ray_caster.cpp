// SPDX-License-Identifier: BSD-3-Clause
#include "servers/vision/embree/ray_caster.h"

#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

#include <embree3/rtcore.h>

namespace hrp {
namespace {

// SSE2 is what every x86-64 has: the same instructions, and so the same choice at the edges of triangles, everywhere.
// It costs a tenth against AVX2. One thread: the vision server takes no more than one core.
constexpr const char* kConfig = "threads=1,set_affinity=0,isa=sse2";

constexpr float kInfinity = std::numeric_limits<float>::infinity();

struct CastContext {
  RTCIntersectContext base;  // first: Embree hands a pointer to it back
  const Ray* ray_W = nullptr;
  double t = std::numeric_limits<double>::infinity();  // of the nearest solid so far
  SceneHit hit;
};

// A float that is no smaller: what is a little nearer than the nearest solid so far must still be looked at.
float round_up(double t) { return std::nextafter(static_cast<float>(t), kInfinity); }

}  // namespace

struct RayCaster::Impl {
  explicit Impl(const std::vector<VisibleShape>& all);
  ~Impl();
  void add_mesh(size_t shape);
  RTCScene make_mesh_scene(const Mesh& mesh);
  void add_solids();
  std::optional<SolidHit> hit_solid(size_t shape, const Ray& ray_W) const;
  std::optional<SceneHit> hit_mesh(const RTCRayHit& found, const Ray& ray_W) const;
  void find_bounds(size_t shape, RTCBounds* bounds) const;
  static void handle_bounds(const RTCBoundsFunctionArguments* arguments);
  static void handle_intersection(const RTCIntersectFunctionNArguments* arguments);

  std::vector<VisibleShape> shapes;
  std::vector<Transform> X_WG;
  std::vector<size_t> planes;           // without an end, so no matter for a tree of boxes
  std::vector<size_t> solids;           // shape of each primitive of solid_geometry
  std::vector<RTCGeometry> instances;   // of meshes
  std::vector<size_t> instance_shapes;  // shape of each instance; its geometry's number in the scene is the same
  std::map<const Mesh*, RTCScene> mesh_scenes;
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  RTCGeometry solid_geometry = nullptr;
};

RayCaster::Impl::Impl(const std::vector<VisibleShape>& all) : shapes(all), X_WG(all.size()) {
  device = rtcNewDevice(kConfig);
  if (device == nullptr)
    throw std::runtime_error("Embree cannot be started: error " + std::to_string(rtcGetDeviceError(nullptr)));
  scene = rtcNewScene(device);
  // Robust: no ray slips through between two triangles. Dynamic: only the poses change between pictures.
  rtcSetSceneFlags(scene, static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_DYNAMIC));
  for (size_t i = 0; i < shapes.size(); ++i) {
    if (shapes[i].kind == VisibleKind::kMesh)
      add_mesh(i);
    else if (shapes[i].kind == VisibleKind::kPlane)
      planes.push_back(i);
    else
      solids.push_back(i);
  }
  if (!solids.empty()) add_solids();
}

RayCaster::Impl::~Impl() {
  for (RTCGeometry instance : instances) rtcReleaseGeometry(instance);
  for (const auto& [mesh, mesh_scene] : mesh_scenes) rtcReleaseScene(mesh_scene);
  if (solid_geometry != nullptr) rtcReleaseGeometry(solid_geometry);
  if (scene != nullptr) rtcReleaseScene(scene);
  if (device != nullptr) rtcReleaseDevice(device);
}

RTCScene RayCaster::Impl::make_mesh_scene(const Mesh& mesh) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                               3 * sizeof(float), mesh.vertices.size()));
  auto* corners = static_cast<unsigned*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                                 3 * sizeof(unsigned), mesh.triangles.size()));
  if (vertices == nullptr || corners == nullptr) throw std::bad_alloc();
  for (const Vector3d& v : mesh.vertices) {
    for (int k = 0; k < 3; ++k) *vertices++ = static_cast<float>(v[k]);
  }
  for (const auto& triangle : mesh.triangles) {
    for (const int corner : triangle) *corners++ = static_cast<unsigned>(corner);
  }
  rtcCommitGeometry(geometry);
  RTCScene mesh_scene = rtcNewScene(device);
  rtcSetSceneFlags(mesh_scene, RTC_SCENE_FLAG_ROBUST);
  rtcAttachGeometry(mesh_scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(mesh_scene);
  return mesh_scene;
}

void RayCaster::Impl::add_mesh(size_t shape) {
  const Mesh* mesh = shapes[shape].mesh.get();
  RTCScene& mesh_scene = mesh_scenes[mesh];
  if (mesh_scene == nullptr) mesh_scene = make_mesh_scene(*mesh);
  RTCGeometry instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(instance, mesh_scene);
  rtcAttachGeometryByID(scene, instance, static_cast<unsigned>(instances.size()));
  instances.push_back(instance);
  instance_shapes.push_back(shape);
}

void RayCaster::Impl::add_solids() {
  solid_geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(solid_geometry, static_cast<unsigned>(solids.size()));
  rtcSetGeometryUserData(solid_geometry, this);
  rtcSetGeometryBoundsFunction(solid_geometry, handle_bounds, nullptr);
  rtcSetGeometryIntersectFunction(solid_geometry, handle_intersection);
  rtcAttachGeometryByID(scene, solid_geometry, static_cast<unsigned>(instances.size()));
}

std::optional<SolidHit> RayCaster::Impl::hit_solid(size_t index, const Ray& ray_W) const {
  const VisibleShape& shape = shapes[index];
  const Ray ray_G = move_ray(ray_W, X_WG[index]);
  switch (shape.kind) {
    case VisibleKind::kBox: return hit_box(ray_G, shape.size);
    case VisibleKind::kSphere: return hit_sphere(ray_G, shape.size.x());
    case VisibleKind::kCylinder: return hit_cylinder(ray_G, shape.size.x(), shape.size.y());
    case VisibleKind::kPlane: return hit_plane(ray_G);
    case VisibleKind::kMesh: break;
  }
  return std::nullopt;
}

std::optional<SceneHit> RayCaster::Impl::hit_mesh(const RTCRayHit& found, const Ray& ray_W) const {
  const size_t index = instance_shapes[found.hit.instID[0]];
  const Mesh& mesh = *shapes[index].mesh;
  const auto& triangle = mesh.triangles[found.hit.primID];
  const auto corner = [&](int k) -> const Vector3d& {
    return mesh.vertices[static_cast<size_t>(triangle[static_cast<size_t>(k)])];
  };
  const auto hit = hit_triangle_plane(move_ray(ray_W, X_WG[index]), {corner(0), corner(1), corner(2)});
  if (!hit) return std::nullopt;
  return SceneHit{hit->t, X_WG[index].R * hit->n_G, index};
}

// Half of the extent along each world axis.
Vector3d find_half_extent(const VisibleShape& shape, const Matrix3d& R_WG) {
  if (shape.kind == VisibleKind::kSphere) return Vector3d::Constant(shape.size.x());
  if (shape.kind == VisibleKind::kBox) return 0.5 * R_WG.cwiseAbs() * shape.size;
  const Vector3d axis = R_WG.col(2);
  const Vector3d across = (Vector3d::Ones() - axis.cwiseProduct(axis)).cwiseMax(0.0).cwiseSqrt();
  return 0.5 * shape.size.y() * axis.cwiseAbs() + shape.size.x() * across;
}

void RayCaster::Impl::find_bounds(size_t index, RTCBounds* bounds) const {
  const Vector3d half = find_half_extent(shapes[index], X_WG[index].R), middle = X_WG[index].p;
  // Floats have 24 bits: wider than their rounding, at both ends.
  const Vector3d margin = 1e-6 * (half + middle.cwiseAbs() + Vector3d::Constant(1.0));
  const Vector3d lower = middle - half - margin, upper = middle + half + margin;
  bounds->lower_x = static_cast<float>(lower.x());
  bounds->upper_x = static_cast<float>(upper.x());
  bounds->lower_y = static_cast<float>(lower.y());
  bounds->upper_y = static_cast<float>(upper.y());
  bounds->lower_z = static_cast<float>(lower.z());
  bounds->upper_z = static_cast<float>(upper.z());
}

void RayCaster::Impl::handle_bounds(const RTCBoundsFunctionArguments* arguments) {
  const auto& self = *static_cast<const Impl*>(arguments->geometryUserPtr);
  self.find_bounds(self.solids[arguments->primID], arguments->bounds_o);
}

void RayCaster::Impl::handle_intersection(const RTCIntersectFunctionNArguments* arguments) {
  const auto& self = *static_cast<const Impl*>(arguments->geometryUserPtr);
  auto& context = *reinterpret_cast<CastContext*>(arguments->context);
  if (arguments->valid[0] == 0) return;
  const size_t shape = self.solids[arguments->primID];
  const auto hit = self.hit_solid(shape, *context.ray_W);
  if (!hit || hit->t >= context.t) return;
  auto& found = *reinterpret_cast<RTCRayHit*>(arguments->rayhit);  // of one ray: rtcIntersect1
  if (hit->t > found.ray.tfar) return;                             // behind a mesh
  context.t = hit->t;
  context.hit = {hit->t, self.X_WG[shape].R * hit->n_G, shape};
  found.ray.tfar = round_up(hit->t);
  found.hit.geomID = arguments->geomID;
  found.hit.primID = arguments->primID;
  found.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
}

RayCaster::RayCaster(const std::vector<VisibleShape>& shapes) : impl_(std::make_unique<Impl>(shapes)) {}
RayCaster::~RayCaster() = default;

void RayCaster::place(const std::vector<Transform>& X_WG) {
  impl_->X_WG = X_WG;
  for (size_t i = 0; i < impl_->instances.size(); ++i) {
    const Transform& X = X_WG[impl_->instance_shapes[i]];
    float columns[12];
    for (int k = 0; k < 9; ++k) columns[k] = static_cast<float>(X.R(k % 3, k / 3));
    for (int k = 0; k < 3; ++k) columns[9 + k] = static_cast<float>(X.p[k]);
    rtcSetGeometryTransform(impl_->instances[i], 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns);
    rtcCommitGeometry(impl_->instances[i]);
  }
  if (impl_->solid_geometry != nullptr) rtcCommitGeometry(impl_->solid_geometry);
  rtcCommitScene(impl_->scene);
}

std::optional<SceneHit> RayCaster::cast(const Ray& ray) const {
  CastContext context;
  rtcInitIntersectContext(&context.base);
  context.ray_W = &ray;
  RTCRayHit found = {};
  found.ray.org_x = static_cast<float>(ray.p.x());
  found.ray.dir_x = static_cast<float>(ray.d.x());
  found.ray.org_y = static_cast<float>(ray.p.y());
  found.ray.dir_y = static_cast<float>(ray.d.y());
  found.ray.org_z = static_cast<float>(ray.p.z());
  found.ray.dir_z = static_cast<float>(ray.d.z());
  found.ray.tnear = static_cast<float>(ray.t_min);
  found.ray.tfar = round_up(ray.t_max);
  found.ray.mask = ~0u;
  found.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  found.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(impl_->scene, &context.base, &found);

  std::optional<SceneHit> nearest;
  if (found.hit.instID[0] != RTC_INVALID_GEOMETRY_ID)
    nearest = impl_->hit_mesh(found, ray);
  else if (found.hit.geomID != RTC_INVALID_GEOMETRY_ID)
    nearest = context.hit;
  for (const size_t plane : impl_->planes) {
    const auto hit = impl_->hit_solid(plane, ray);
    if (hit && (!nearest || hit->t < nearest->t)) nearest = SceneHit{hit->t, impl_->X_WG[plane].R * hit->n_G, plane};
  }
  return nearest;
}

}  // namespace hrp
