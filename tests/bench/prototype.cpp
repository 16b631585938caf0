// SPDX-License-Identifier: GPL-3.0-or-later
// The floor to beat, rebuilt: a small progressive photon mapper for one scene, the large box of box.py, that
// does no more than its image needs: scalar code, floats, no edits, no adaptivity, glass chosen at random, no
// depth limit, every class of light by one simple estimator. It reaches the errors of the prototype that the
// floor's figures (box.FLOOR) are of, pass for pass, so that its seconds say what they are on this machine.
// Numbers: one stream of shuffled Owen-scrambled Sobol' pairs, index = pass; plain random ones do not reach
// those errors.
//   prototype PASSES SEED OUT.raw [THREADS [PHOTONS]]    float32 RGB, 256 x 256, row 0 at the bottom
// Prints: seconds to set up the scene, seconds of the passes, photon paths per second, shares of photons and
// view.

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif
#include <immintrin.h>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <numbers>
#include <numeric>
#include <thread>
#include <vector>

constexpr float pi = std::numbers::pi_v<float>;
constexpr float first_radius = 0.08f, caustic_share = 0.5f, alpha = 2.0f / 3.0f, ior = 1.5f, offset = 1e-4f;
constexpr float lamp_half = 0.25f, lamp_y = 0.999f, lamp_radiance = 15.0f,
                lamp_area = 4 * lamp_half * lamp_half;
// a path of 1000 events is caught in the glass by rounding
constexpr int size = 256, chunk = 256, endless = 1000;

struct Vec {
  float x = 0, y = 0, z = 0;
};
inline Vec operator+(Vec a, Vec b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec operator-(Vec a, Vec b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec operator-(Vec a) { return {-a.x, -a.y, -a.z}; }
inline Vec operator*(Vec a, Vec b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
inline Vec operator*(Vec a, float s) { return {a.x * s, a.y * s, a.z * s}; }
inline float dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec normalized(Vec a) { return a * (1 / std::sqrt(dot(a, a))); }

struct Pair {
  float a, b;
};
inline float to_unit(uint32_t bits) { return float(bits >> 8) * 0x1p-24f; }
inline uint32_t hash(uint32_t a, uint32_t b) {
  const uint64_t g = (uint64_t(a) << 32 | b) * 0x9E3779B97F4A7C15u, h = (g ^ g >> 32) * 0xD6E8FEB86659FD93u;
  return uint32_t(h ^ h >> 32);
}

inline uint32_t reversed(uint32_t v) {
  v = __builtin_bswap32(v);
  v = (v >> 4 & 0x0F0F0F0F) | (v & 0x0F0F0F0F) << 4;
  v = (v >> 2 & 0x33333333) | (v & 0x33333333) << 2;
  return (v >> 1 & 0x55555555) | (v & 0x55555555) << 1;
}

// Owen scrambling of a number whose bits are reversed (Laine and Karras, constants of Vegdahl)
inline uint32_t scrambled(uint32_t v, uint32_t seed) {
  v = ((v ^ v * 0x3D20ADEA) + seed) * (seed >> 16 | 1);
  v ^= v * 0x05526C56;
  return v ^ v * 0x53A22864;
}

// Numbers of one path, named by their place in it
struct Numbers {
  uint32_t key, index;
  Pair pair(uint32_t place) const {
    const uint32_t seed = hash(key, place);
    uint32_t v = reversed(scrambled(reversed(index), seed));
    const float a = to_unit(reversed(scrambled(v, seed * 0x2C1B3C6D + 1)));
    constexpr uint32_t masks[] = {0x55555555, 0x33333333, 0x0F0F0F0F, 0x00FF00FF, 0x0000FFFF};
    // Pascal's triangle modulo 2: the second dimension, bits reversed
    for (int i = 0; i < 5; ++i) v ^= v >> (1 << i) & masks[i];
    return {a, to_unit(reversed(scrambled(v, seed * 0x297A2D39 + 1)))};
  }
};

// A direction about n with density cos / pi (basis of Duff et al. 2017)
inline Vec cosine_direction(Vec n, Pair u) {
  const float radius = std::sqrt(u.a), angle = 2 * pi * u.b;
  const float x = radius * std::cos(angle), y = radius * std::sin(angle),
              z = std::sqrt(std::max(0.0f, 1 - u.a));
  const float sign = std::copysign(1.0f, n.z), a = -1 / (sign + n.z), b = n.x * n.y * a;
  return Vec{1 + sign * n.x * n.x * a, sign * b, -sign * n.x} * x + Vec{b, sign + n.y * n.y * a, -n.y} * y +
         n * z;
}

enum class Kind { diffuse, mirror, glass, lamp };
struct Object {
  Kind kind;
  Vec color;
  std::vector<Vec> corners, normals;  // flat without normals
  std::vector<uint32_t> triangles;
};
struct Ray {
  Vec from, to;
};  // to: unit direction
struct Hit {
  const Object* object = nullptr;
  Vec p, flat, smooth;  // normals as modelled
};
Object quad(Kind kind, Vec color, Vec a, Vec b, Vec c, Vec d) {
  return {kind, color, {a, b, c, d}, {}, {0, 1, 2, 0, 2, 3}};
}

// Blender's UV sphere of 256 segments and 128 rings, poles along z
Object ball(Kind kind, Vec color, Vec centre) {
  constexpr uint32_t segments = 256, rings = 128;
  Object ball{kind, color, {}, {}, {}};
  for (uint32_t i = 0; i < (rings + 1) * segments; ++i) {
    const uint32_t ring = i / segments, next = i % segments == segments - 1 ? i + 1 - segments : i + 1;
    const float theta = pi * float(ring) / rings, phi = 2 * pi * float(i % segments) / segments;
    ball.normals.push_back(
        {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)});
    ball.corners.push_back(centre + ball.normals.back() * 0.4f);
    if (ring > 0 && ring < rings) ball.triangles.insert(ball.triangles.end(), {i, next + segments, next});
    if (ring < rings - 1) ball.triangles.insert(ball.triangles.end(), {i, i + segments, next + segments});
  }
  return ball;
}

std::vector<Object> box() {
  const Vec white{0.75f, 0.75f, 0.75f}, red{0.75f, 0.25f, 0.25f}, green{0.25f, 0.75f, 0.25f};
  const Vec lbf{-1, -1, 1}, rbf{1, -1, 1}, ltf{-1, 1, 1}, rtf{1, 1, 1}, lbb{-1, -1, -1}, rbb{1, -1, -1},
      ltb{-1, 1, -1}, rtb{1, 1, -1};
  constexpr float h = lamp_half, y = lamp_y;
  return {quad(Kind::diffuse, white, lbb, lbf, rbf, rbb),
          quad(Kind::diffuse, white, ltb, rtb, rtf, ltf),
          quad(Kind::diffuse, white, lbb, rbb, rtb, ltb),
          quad(Kind::diffuse, red, lbf, lbb, ltb, ltf),
          quad(Kind::diffuse, green, rbb, rbf, rtf, rtb),
          quad(Kind::lamp, {}, {-h, y, -h}, {h, y, -h}, {h, y, h}, {-h, y, h}),
          ball(Kind::glass, {1, 1, 1}, {0.4f, -0.6f, 0.25f}),
          ball(Kind::mirror, {0.9f, 0.9f, 0.9f}, {-0.42f, -0.6f, -0.3f})};
}

struct Scene {
  std::vector<Object> objects = box();
  RTCDevice device = rtcNewDevice(nullptr);
  RTCScene scene = rtcNewScene(device);
  Scene() {
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    for (unsigned id = 0; id < objects.size(); ++id) {
      const Object& object = objects[id];
      RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
      const auto copy = [&](RTCBufferType type, RTCFormat format, const void* from, size_t count) {
        std::memcpy(rtcSetNewGeometryBuffer(geometry, type, 0, format, 12, count), from, 12 * count);
      };
      copy(RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, object.corners.data(), object.corners.size());
      copy(RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, object.triangles.data(), object.triangles.size() / 3);
      rtcCommitGeometry(geometry);
      rtcAttachGeometryByID(scene, geometry, id);
      rtcReleaseGeometry(geometry);
    }
    rtcCommitScene(scene);
  }
  bool intersect(const Ray& ray, RTCRayHit& record) const {
    record.ray = {ray.from.x, ray.from.y, ray.from.z, 0,          ray.to.x, ray.to.y,
                  ray.to.z,   0,          INFINITY,   0xFFFFFFFF, 0,        0};
    record.hit.geomID = record.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
    rtcIntersect1(scene, &record);
#else
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene, &context, &record);
#endif
    return record.hit.geomID != RTC_INVALID_GEOMETRY_ID;
  }
  Hit trace(const Ray& ray) const {
    RTCRayHit record;
    if (!intersect(ray, record)) return {};
    const RTCHit& hit = record.hit;
    const Object& object = objects[hit.geomID];
    const Vec p = ray.from + ray.to * record.ray.tfar, flat = normalized({hit.Ng_x, hit.Ng_y, hit.Ng_z}),
              *n = object.normals.data();
    if (!n) return {&object, p, flat, flat};
    const uint32_t* corner = &object.triangles[3 * hit.primID];
    return {&object, p, flat,
            normalized(n[corner[0]] * (1 - hit.u - hit.v) + n[corner[1]] * hit.u + n[corner[2]] * hit.v)};
  }
  bool blocked(Vec from, Vec way) const {
    RTCRay ray{from.x, from.y, from.z, 0, way.x, way.y, way.z, 0, 1 - offset, 0xFFFFFFFF, 0, 0};
#if RTC_VERSION_MAJOR >= 4
    rtcOccluded1(scene, &ray);
#else
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded1(scene, &context, &ray);
#endif
    return ray.tfar < 0;
  }
};

inline Vec facing(Vec normal, Vec ray) { return dot(normal, ray) > 0 ? -normal : normal; }
inline bool sees_lamp(const Hit& hit, Vec ray) { return hit.object->kind == Kind::lamp && ray.y > 0; }

// Reflectance of glass for a ray that comes in at cosine c; ratio = refractive index here / beyond; t =
// cosine beyond
inline float fresnel(float c, float ratio, float& t) {
  const float sine2 = ratio * ratio * (1 - c * c);
  if (sine2 >= 1) return 1;
  t = std::sqrt(1 - sine2);
  const float parallel = (c - ratio * t) / (c + ratio * t), across = (ratio * c - t) / (ratio * c + t);
  return 0.5f * (parallel * parallel + across * across);
}

// The ray after a mirror or glass; u chooses between reflection and refraction, so glass needs no weight
Ray followed(const Hit& hit, Vec in, float u) {
  const bool outside = dot(in, hit.flat) < 0;
  const Vec flat = outside ? hit.flat : -hit.flat;
  Vec normal = outside ? hit.smooth : -hit.smooth;
  // grazing: keep it on its side
  if (dot(in, normal) >= 0 || dot(in - normal * (2 * dot(in, normal)), flat) <= 0) normal = flat;
  const float c = -dot(in, normal), ratio = outside ? 1 / ior : ior;
  float t = 0;
  if (hit.object->kind == Kind::mirror || u < fresnel(c, ratio, t))
    return {hit.p + flat * offset, in + normal * (2 * c)};
  return {hit.p - flat * offset, normalized(in * ratio + normal * (ratio * c - t))};
}

struct Photon {
  Vec p, flux, normal;  // the normal of the side it arrived at
  bool caustic;         // came from a mirror or glass
};
struct alignas(64) List {
  std::vector<Photon> photons;
};  // of one thread, on a cache line of its own

// Photons in the order of their cells; a cell is at least 2 radii wide, so a query touches at most 2 along
// each axis
struct Grid {
  struct Load {
    Vec flux, normal;
  };
  float radius = 0;
  int n = 1;
  std::vector<uint32_t> start;
  std::vector<float> xs, ys, zs;
  std::vector<Load> loads;
  int cell(float v) const { return std::clamp(int((v + 1) * (0.5f * float(n))), 0, n - 1); }
  size_t row(int y, int z) const { return (size_t(z) * n + y) * n; }
  void build(const std::vector<List>& lists, float wanted_radius, bool only_caustics) {
    radius = wanted_radius;
    n = std::clamp(int(1 / radius), 1, 100);
    // one more in front: after filling, start[i] is where cell i starts
    start.assign(size_t(n) * n * n + 2, 0);
    const auto each = [&](const auto& work) {  // with the place of the photon's cell in start
      for (const List& list : lists)
        for (const Photon& photon : list.photons)
          if (photon.caustic || !only_caustics)
            work(photon, start.data() + row(cell(photon.p.y), cell(photon.p.z)) + cell(photon.p.x));
    };
    each([](const Photon&, uint32_t* first) { ++first[2]; });
    std::partial_sum(start.begin(), start.end(), start.begin());
    xs.resize(start.back()), ys.resize(start.back()), zs.resize(start.back()), loads.resize(start.back());
    each([&](const Photon& photon, uint32_t* first) {
      const uint32_t at = first[1]++;
      xs[at] = photon.p.x, ys[at] = photon.p.y, zs[at] = photon.p.z, loads[at] = {photon.flux, photon.normal};
    });
  }
  // Irradiance at p on a side of a surface
  Vec irradiance(Vec p, Vec side) const {
    Vec sum;
    const int x0 = cell(p.x - radius), x1 = cell(p.x + radius), y1 = cell(p.y + radius),
              z1 = cell(p.z + radius);
    for (int z = cell(p.z - radius); z <= z1; ++z)
      for (int y = cell(p.y - radius); y <= y1; ++y)
        for (uint32_t i = start[row(y, z) + x0], end = start[row(y, z) + x1 + 1]; i < end;) {
          // in two steps: one photon in five is near, no branch predictor likes that
          uint32_t found[64], count = 0;
          for (const uint32_t stop = std::min(i + 64, end); i < stop; ++i) {
            const float dx = xs[i] - p.x, dy = ys[i] - p.y, dz = zs[i] - p.z;
            found[count] = i;
            count += dx * dx + dy * dy + dz * dz < radius * radius;
          }
          for (uint32_t k = 0; k < count; ++k)
            if (dot(loads[found[k]].normal, side) > 0.7f) sum = sum + loads[found[k]].flux;
        }
    return sum * (1 / (pi * radius * radius));
  }
};

// Photons straight from the lamp are not stored: next-event estimation stands for them at v and at y
void trace_photon(const Scene& scene, const Numbers& numbers, float power, std::vector<Photon>& photons) {
  const Pair at = numbers.pair(0);
  Ray ray{{lamp_half * (2 * at.a - 1), lamp_y - offset, lamp_half * (2 * at.b - 1)},
          cosine_direction({0, -1, 0}, numbers.pair(1))};
  Vec flux{power, power, power};
  bool caustic = false;
  for (uint32_t event = 0; event < endless; ++event) {
    const Hit hit = scene.trace(ray);
    if (!hit.object || hit.object->kind == Kind::lamp) return;
    const bool diffuse = hit.object->kind == Kind::diffuse;
    const Vec normal = facing(hit.flat, ray.to), color = hit.object->color;
    if (diffuse && event > 0) photons.push_back({hit.p, flux, normal, caustic});
    const Pair u = numbers.pair(2 + 2 * event);
    const float survival = std::max({color.x, color.y, color.z});
    if (u.a >= survival) return;
    flux = flux * color * (1 / survival);
    ray = diffuse ? Ray{hit.p + normal * offset, cosine_direction(normal, numbers.pair(3 + 2 * event))}
                  : followed(hit, ray.to, u.b);
    caustic = !diffuse;
  }
}

struct Maps {
  Grid all, caustics;
};
// Light straight from the lamp that leaves a diffuse surface; with mis, weighed against a cosine-sampled ray
// (balance heuristic)
Vec direct(const Scene& scene, const Hit& hit, Vec normal, Pair u, bool mis) {
  const Vec from = hit.p + normal * offset,
            way = Vec{lamp_half * (2 * u.a - 1), lamp_y, lamp_half * (2 * u.b - 1)} - from;
  const float square = dot(way, way), length = std::sqrt(square), cosine = dot(way, normal) / length,
              at_lamp = way.y / length;
  if (cosine <= 0 || at_lamp <= 0 || scene.blocked(from, way)) return {};
  const float to_lamp = square / (at_lamp * lamp_area), by_cosine = cosine / pi;
  return hit.object->color * (lamp_radiance * by_cosine / (mis ? to_lamp + by_cosine : to_lamp));
}

// One cosine-sampled segment to y: the lamp (the other half of direct light), or at y direct light and all
// photons
Vec gathered(const Scene& scene, const Maps& maps, const Hit& v, Vec normal, const Numbers& numbers) {
  const Ray ray{v.p + normal * offset, cosine_direction(normal, numbers.pair(2))};
  const Hit y = scene.trace(ray);
  if (!y.object) return {};
  if (sees_lamp(y, ray.to)) {
    const Vec way = y.p - ray.from;
    const float to_lamp = dot(way, way) / (ray.to.y * lamp_area), by_cosine = dot(ray.to, normal) / pi;
    return v.object->color * (lamp_radiance * by_cosine / (to_lamp + by_cosine));
  }
  if (y.object->kind != Kind::diffuse) return {};  // light from glass and mirrors is in the caustics at v
  const Vec side = facing(y.flat, ray.to),
            photons = y.object->color * maps.all.irradiance(y.p, side) * (1 / pi);
  return v.object->color * (direct(scene, y, side, numbers.pair(3), false) + photons);
}

Vec view_path(const Scene& scene, const Maps& maps, Ray ray, const Numbers& numbers) {
  Vec weight{1, 1, 1};
  for (uint32_t event = 0; event < endless; ++event) {
    const Hit hit = scene.trace(ray);
    if (!hit.object) return {};
    if (hit.object->kind == Kind::lamp) return sees_lamp(hit, ray.to) ? weight * lamp_radiance : Vec{};
    if (hit.object->kind == Kind::diffuse) {
      const Vec normal = facing(hit.flat, ray.to),
                caustics = hit.object->color * maps.caustics.irradiance(hit.p, normal) * (1 / pi);
      return weight * (direct(scene, hit, normal, numbers.pair(1), true) + caustics +
                       gathered(scene, maps, hit, normal, numbers));
    }
    weight = weight * hit.object->color;
    ray = followed(hit, ray.to, numbers.pair(4 + event).a);
  }
  return {};
}

Ray camera_ray(int pixel, Pair u) {
  const float edge = std::tan(39 * pi / 360), step = 2 * edge / size;
  return {
      {0, 0, 4},
      normalized({(float(pixel % size) + u.a) * step - edge, (float(pixel / size) + u.b) * step - edge, -1})};
}

inline double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// work(thread, i) for all i < count, handed out in chunks; returns the seconds it took
template <class Work>
double parallel(int threads, int count, const Work& work) {
  const double begin = now();
  std::atomic<int> next = 0;
  const auto run = [&](int thread) {
    _mm_setcsr(_mm_getcsr() | 0x8040);  // denormal numbers are zero: Embree asks for it
    for (int first; (first = next.fetch_add(chunk)) < count;)
      for (int i = first; i < std::min(first + chunk, count); ++i) work(thread, i);
  };
  std::vector<std::jthread> others;
  for (int thread = 1; thread < threads; ++thread) others.emplace_back(run, thread);
  run(0);
  others.clear();  // joins
  return now() - begin;
}

std::vector<Vec> render(const Scene& scene, int passes, uint32_t seed, int threads, int photons,
                        double setup) {
  std::vector<Vec> film(size * size);
  std::vector<List> lists(threads);
  Maps maps;
  double photon_time = 0, view_time = 0, square = first_radius * first_radius;
  const float power = lamp_radiance * pi * lamp_area / float(photons);
  const double begin = now();
  for (int pass = 0; pass < passes; ++pass) {
    for (List& list : lists) list.photons.clear();
    const uint32_t photon_key = hash(hash(seed, 1), pass), view_key = hash(seed, 2);
    const auto photon = [&](int thread, int i) {
      trace_photon(scene, Numbers{photon_key, uint32_t(i)}, power, lists[thread].photons);
    };
    photon_time += parallel(threads, photons, photon);
    const float radius = float(std::sqrt(square));
    maps.all.build(lists, radius, false), maps.caustics.build(lists, radius * caustic_share, true);
    view_time += parallel(threads, size * size, [&](int, int pixel) {
      const Numbers numbers{hash(view_key, pixel), uint32_t(pass)};
      film[pixel] = film[pixel] + view_path(scene, maps, camera_ray(pixel, numbers.pair(0)), numbers);
    });
    square *= (pass + alpha) / (pass + 1);  // Knaus and Zwicker 2011
  }
  const double seconds = now() - begin, paths = double(photons) * passes;
  std::printf("%.4f %.4f %.0f %.3f %.3f\n", setup, seconds, paths / photon_time, photon_time / seconds,
              view_time / seconds);
  for (Vec& pixel : film) pixel = pixel * (1 / float(passes));
  return film;
}

int main(int count, char** words) {
  if (count < 4) return std::fputs("prototype PASSES SEED OUT.raw [THREADS [PHOTONS]]\n", stderr), 2;
  const int threads = count > 4 ? std::max(1, std::atoi(words[4])) : 2,
            photons = count > 5 ? std::max(1, std::atoi(words[5])) : 32768;
  const double begin = now();
  const Scene scene;
  const std::vector<Vec> film =
      render(scene, std::atoi(words[1]), uint32_t(std::atoi(words[2])), threads, photons, now() - begin);
  FILE* file = std::fopen(words[3], "wb");
  if (!file || std::fwrite(film.data(), sizeof(Vec), film.size(), file) != film.size() || std::fclose(file))
    return std::perror(words[3]), 1;
  return 0;
}
