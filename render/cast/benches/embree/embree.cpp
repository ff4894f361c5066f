// Embree as a caster of terrain: what sandtable's casters are measured against.
//
// Reads requests, a line each, on standard input and answers each with a line on standard output.
// What follows a line is binary, in the machine's byte order. World frame: metres, x east, y north,
// z up; row 0 of a terrain is south, row 0 of an image its top; colours are R, G, B, any.
//
//   terrain COLS ROWS DX DY  and COLS * ROWS heights (float), then as many colours
//                            -> terrain BYTES      held for vertices and colours
//   build grid|triangles     -> built MS BYTES PEAK    on one thread; what Embree holds for it
//   view W H and 12 numbers: eye, direction through the centre of pixel (0, 0), step a column, step
//                            a row  -> view
//   frame grid|triangles N   -> frame MS           on N pinned threads
//   image                    -> image BYTES  and W * H depths (float, metres), then as many colours
//
// A frame traces packets of 4 by 4 pixels, coherent, in tiles of 16 by 16 that the threads take in
// turn, and writes colour (one bilinear fetch a hit) and depth of each pixel.

#include <embree3/rtcore.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <iostream>
#include <latch>
#include <map>
#include <sched.h>
#include <string>
#include <thread>
#include <vector>
#ifdef __SSE__
#include <pmmintrin.h>
#endif

using Clock = std::chrono::steady_clock;

// One word for each pixel of a packet.
typedef float Floats __attribute__((vector_size(64)));
typedef int32_t Ints __attribute__((vector_size(64)));
typedef uint32_t Words __attribute__((vector_size(64)));

struct Vertex { float x, y, z; };

struct Terrain {
    int cols, rows;
    float dx, dy;
    std::vector<Vertex> vertices;
    std::vector<uint32_t> colours;
};

struct View {
    int width, height;
    float eye[3], corner[3], right[3], down[3];
};

struct Image {
    int stride; // both sides are rounded up to whole packets
    std::vector<uint32_t> colour;
    std::vector<float> depth;
};

static const int TILE = 16, PACKET = 4;
static const uint32_t SKY = 0xffe8d8c8, OPAQUE = 0xff000000;

// Bytes that Embree holds, and held at most; it builds on one thread, so no two count at once.
static long held = 0, peak = 0;

static bool count_memory(void *, ssize_t bytes, bool) {
    peak = std::max(peak, held += bytes);
    return true;
}

static double milliseconds_since(Clock::time_point begin) {
    return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

// Binds the calling thread to the k-th of the processors that the program was started with, and
// lets it take denormal numbers for zero, as Embree asks. A thread inherits the binding of the one
// that starts it, so each binds itself.
static void set_up_thread(int k) {
    static const cpu_set_t allowed = [] {
        cpu_set_t set;
        sched_getaffinity(0, sizeof set, &set);
        return set;
    }();
    int cpu = 0;
    for (int left = k % CPU_COUNT(&allowed); !CPU_ISSET(cpu, &allowed) || left-- > 0;) cpu++;
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(cpu, &one);
    sched_setaffinity(0, sizeof one, &one);
#ifdef __SSE__
    _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
    _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
#endif
}

static RTCScene build(RTCDevice device, Terrain &terrain, bool as_grid) {
    auto kind = as_grid ? RTC_GEOMETRY_TYPE_GRID : RTC_GEOMETRY_TYPE_TRIANGLE;
    RTCGeometry geometry = rtcNewGeometry(device, kind);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                               terrain.vertices.data(), 0, sizeof(Vertex), terrain.vertices.size());
    int cols = terrain.cols, rows = terrain.rows;
    if (as_grid) {
        void *grid = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID,
                                             sizeof(RTCGrid), 1);
        *static_cast<RTCGrid *>(grid) = {0, unsigned(cols), uint16_t(cols), uint16_t(rows)};
    } else {
        void *indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                12, size_t(cols - 1) * (rows - 1) * 2);
        auto *index = static_cast<unsigned *>(indices);
        for (int row = 0; row + 1 < rows; row++)
            for (int col = 0; col + 1 < cols; col++) {
                unsigned sw = row * cols + col, se = sw + 1, nw = sw + cols;
                for (unsigned corner : {sw, se, nw, se, nw + 1, nw}) *index++ = corner;
            }
    }
    rtcCommitGeometry(geometry);
    RTCScene scene = rtcNewScene(device);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
    return scene;
}

// The colours at 16 places, in posts, bilinear.
static Words colours_at(const Terrain &terrain, Floats x, Floats y) {
    const float last_col = terrain.cols - 1.001f, last_row = terrain.rows - 1.001f;
    x = x > 0 ? x : 0, x = x < last_col ? x : last_col;
    y = y > 0 ? y : 0, y = y < last_row ? y : last_row;
    Ints col = __builtin_convertvector(x, Ints), row = __builtin_convertvector(y, Ints);
    Floats u = x - __builtin_convertvector(col, Floats), v = y - __builtin_convertvector(row, Floats);
    Ints at = row * terrain.cols + col;
    const uint32_t *south = terrain.colours.data(), *north = south + terrain.cols;
    Words sw, se, nw, ne, mixed = OPAQUE - Words{};
    for (int k = 0; k < 16; k++) {
        sw[k] = south[at[k]], se[k] = south[at[k] + 1];
        nw[k] = north[at[k]], ne[k] = north[at[k] + 1];
    }
    for (int shift = 0; shift < 24; shift += 8) {
        auto channel = [shift](Words texels) {
            return __builtin_convertvector(Ints(texels >> shift & 255), Floats);
        };
        Floats below = channel(sw) + (channel(se) - channel(sw)) * u;
        Floats above = channel(nw) + (channel(ne) - channel(nw)) * u;
        mixed |= Words(__builtin_convertvector(below + (above - below) * v + 0.5f, Ints)) << shift;
    }
    return mixed;
}

// Casts the packet of pixels from (x0, y0) on.
static void cast_packet(RTCScene scene, const Terrain &terrain, const View &view, Image &image,
                        int x0, int y0, RTCIntersectContext &context) {
    const Ints lane = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
    Ints i = x0 + (lane & 3), j = y0 + (lane >> 2);
    Ints valid = (i < view.width) & (j < view.height);
    Floats x = __builtin_convertvector(i, Floats), y = __builtin_convertvector(j, Floats), d[3];
    for (int k = 0; k < 3; k++) d[k] = view.corner[k] + x * view.right[k] + y * view.down[k];

    RTCRayHit16 rays;
    auto set = [](auto &field, auto value) { std::memcpy(field, &value, sizeof value); };
    set(rays.ray.org_x, view.eye[0] - Floats{});
    set(rays.ray.org_y, view.eye[1] - Floats{});
    set(rays.ray.org_z, view.eye[2] - Floats{});
    set(rays.ray.dir_x, d[0]);
    set(rays.ray.dir_y, d[1]);
    set(rays.ray.dir_z, d[2]);
    set(rays.ray.tnear, Floats{});
    set(rays.ray.tfar, INFINITY - Floats{});
    set(rays.ray.time, Floats{});
    set(rays.ray.mask, ~Words{});
    set(rays.ray.id, Words{});
    set(rays.ray.flags, Words{});
    set(rays.hit.geomID, RTC_INVALID_GEOMETRY_ID - Words{});
    set(rays.hit.instID[0], RTC_INVALID_GEOMETRY_ID - Words{});
    rtcIntersect16(reinterpret_cast<int *>(&valid), scene, &context, &rays);

    // Directions are not of length 1, so what Embree found is in multiples of their lengths.
    Floats reach, metres, squares = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    std::memcpy(&reach, rays.ray.tfar, sizeof reach);
    for (int k = 0; k < 16; k++) metres[k] = reach[k] * std::sqrt(squares[k]);
    Ints hit = reach < INFINITY;
    Floats t = hit ? reach : 0;
    Words colour = colours_at(terrain, (view.eye[0] + t * d[0]) / terrain.dx,
                              (view.eye[1] + t * d[1]) / terrain.dy);
    colour = hit ? colour : SKY - Words{};
    for (int row = 0; row < PACKET; row++) {
        size_t at = size_t(y0 + row) * image.stride + x0;
        std::memcpy(&image.colour[at], reinterpret_cast<uint32_t *>(&colour) + PACKET * row, 16);
        std::memcpy(&image.depth[at], reinterpret_cast<float *>(&metres) + PACKET * row, 16);
    }
}

// Casts a frame and returns its milliseconds; the threads are there before the clock starts.
static double cast(RTCScene scene, const Terrain &terrain, const View &view, Image &image,
                   int threads) {
    int across = (view.width + TILE - 1) / TILE, down = (view.height + TILE - 1) / TILE;
    std::atomic<int> next{0};
    std::latch ready(threads);
    Clock::time_point begin;
    auto work = [&](int thread) {
        set_up_thread(thread);
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
        ready.arrive_and_wait();
        if (thread == 0) begin = Clock::now();
        for (int tile; (tile = next++) < across * down;) {
            int x0 = tile % across * TILE, y0 = tile / across * TILE;
            for (int y = y0; y < std::min(y0 + TILE, view.height); y += PACKET)
                for (int x = x0; x < std::min(x0 + TILE, view.width); x += PACKET)
                    cast_packet(scene, terrain, view, image, x, y, context);
        }
    };
    std::vector<std::thread> others;
    for (int thread = 1; thread < threads; thread++) others.emplace_back(work, thread);
    work(0);
    for (auto &thread : others) thread.join();
    return milliseconds_since(begin);
}

template <class T> static void read(std::vector<T> &into) {
    std::cin.read(reinterpret_cast<char *>(into.data()), into.size() * sizeof(T));
}

template <class T> static void write(const std::vector<T> &pixels, int stride, const View &view) {
    for (size_t row = 0; row < size_t(view.height); row++)
        std::cout.write(reinterpret_cast<const char *>(&pixels[row * stride]), view.width * sizeof(T));
}

int main() {
    std::ios::sync_with_stdio(false);
    set_up_thread(0);
    RTCDevice device = rtcNewDevice("threads=1");
    rtcSetDeviceMemoryMonitorFunction(device, count_memory, nullptr);
    Terrain terrain;
    View view;
    Image image;
    std::map<std::string, RTCScene> scenes;
    std::string request, kind;
    while (std::cin >> request) {
        if (request == "terrain") {
            std::cin >> terrain.cols >> terrain.rows >> terrain.dx >> terrain.dy;
            std::cin.get();
            size_t posts = size_t(terrain.cols) * terrain.rows;
            terrain.vertices.reserve(posts + 1); // Embree loads 16 bytes a vertex, the last one too
            terrain.colours.resize(posts);
            std::vector<float> heights(terrain.cols);
            for (int row = 0; row < terrain.rows; row++) {
                read(heights);
                for (int col = 0; col < terrain.cols; col++)
                    terrain.vertices.push_back({col * terrain.dx, row * terrain.dy, heights[col]});
            }
            read(terrain.colours);
            std::cout << "terrain " << posts * (sizeof(Vertex) + sizeof(uint32_t)) << '\n';
        } else if (request == "build" && std::cin >> kind) {
            long before = peak = held;
            auto begin = Clock::now();
            scenes[kind] = build(device, terrain, kind == "grid");
            double time = milliseconds_since(begin);
            std::cout << "built " << time << ' ' << held - before << ' ' << peak - before << '\n';
        } else if (request == "view") {
            std::cin >> view.width >> view.height;
            for (float *vector : {view.eye, view.corner, view.right, view.down})
                std::cin >> vector[0] >> vector[1] >> vector[2];
            image.stride = (view.width + PACKET - 1) / PACKET * PACKET;
            image.colour.resize(image.stride * size_t((view.height + PACKET - 1) / PACKET * PACKET));
            image.depth.resize(image.colour.size());
            std::cout << "view\n";
        } else if (request == "frame" && std::cin >> kind) {
            int threads;
            std::cin >> threads;
            std::cout << "frame " << cast(scenes.at(kind), terrain, view, image, threads) << '\n';
        } else if (request == "image") {
            std::cout << "image " << view.width * size_t(view.height) * 8 << '\n';
            write(image.depth, image.stride, view);
            write(image.colour, image.stride, view);
        } else {
            std::cout << "error " << request << '\n';
        }
        std::cout.flush();
        if (RTCError error = rtcGetDeviceError(device))
            std::cerr << "Embree's error " << error << '\n';
    }
}
