// What is known of one directed Voronoi edge, and what remains of it when a new sample's cell crops the edge
// (planner/DESIGN.md, "State" and "Insertion").
#pragma once

#include <cstdint>

#include "planner/geometry.h"

namespace palpate {

// A number that whoever moves a tool gives to a place where it was or can go. Nothing here knows what it means; who has no tool gives none.
using Anchor = std::uint32_t;
inline constexpr Anchor kNoAnchor = ~Anchor{0};

enum class EdgeState : std::uint8_t {
    unknown,
    clear,     // the whole edge inside ω is free, and so are both its ends
    crossing,  // S meets the edge, as the edge's Crossing says
    failed,    // was probed without an answer: as good as unknown, but not asked again until the edge changes
};

// Where S meets an edge, as seen from one of its ends.
struct Crossing {
    Point near = Point::Zero();  // outside O or on S: S meets the edge between here and `far`
    Point far = Point::Zero();   // inside O or on S. A touched point c has near == far == c
    Point from = Point::Zero();  // everything between here and near is free
    // `from` is where the edge starts: its Voronoi vertex, or where it enters ω; otherwise a point q of the edge, and between the vertex
    // and q nothing is known.
    bool from_vertex = true;
    bool inferred = false;                    // no touch: planner/DESIGN.md, "Inference"
    Anchor from_anchor = kNoAnchor;           // at `from`
    Anchor near_anchor = kNoAnchor;           // at `near`; kNoAnchor if no tool ever was there
    std::uint32_t touch = ~std::uint32_t{0};  // number of the touch at `near`, for who asks which it was
    double ball_radius = 0.0;                 // mm: of the largest surface Delaunay ball that the gap allows
};

// The fate of a boundary edge u → w of the conflict hole when w is destroyed and the new cell's vertex v cuts it:
// what u's record becomes, and what the new cell's record (v → u) becomes.
struct CroppedEdge {
    EdgeState from_u = EdgeState::unknown;  // `crossing` keeps u's own crossing as it is
    EdgeState from_v = EdgeState::unknown;  // `crossing` takes over w's crossing
    bool frees_v = false;
    // v lies on the segment that was traversed for u's record (true) or for w's (false); meaningful with frees_v.
    bool on_segment_of_u = true;
    // w's crossing, seen from within, now is seen from v: v lies between q and the crossing.
    bool from_v_becomes_vertex = false;
};

// `in_new_cell(x)` says whether a point of the old edge lies in V(p). Crossings may be null where the state says so.
template <typename InNewCell>
CroppedEdge crop_edge(EdgeState u_state, const Crossing* u_crossing, EdgeState w_state, const Crossing* w_crossing,
                      const InNewCell& in_new_cell) {
    CroppedEdge result;
    if (u_state == EdgeState::clear) {
        result.from_u = result.from_v = EdgeState::clear;
        result.frees_v = true;
        return result;
    }
    if (u_state == EdgeState::crossing) {
        const bool near_cut = in_new_cell(u_crossing->near);
        const bool far_cut = in_new_cell(u_crossing->far);
        const bool from_cut = in_new_cell(u_crossing->from);
        if (!near_cut && !far_cut) {
            result.from_u = EdgeState::crossing;
        } else if (near_cut && u_crossing->from_vertex) {
            // Everything from u to beyond v is free; the crossing, or its gap, leaves the edge.
            result.from_u = result.from_v = EdgeState::clear;
            result.frees_v = true;
            return result;
        } else if (near_cut && !from_cut) {
            result.frees_v = true;  // q–c covers v, but nothing is known between u and q
        }
        // A gap that v cuts, and a crossing that goes with the part of the edge that goes: unknown.
    }
    // near lies between w and far, so far is cut only if near is.
    if (w_state == EdgeState::crossing && !in_new_cell(w_crossing->near) && !in_new_cell(w_crossing->far)) {
        result.from_v = EdgeState::crossing;
        if (w_crossing->from_vertex || in_new_cell(w_crossing->from)) {
            result.frees_v = true;
            result.on_segment_of_u = false;
            result.from_v_becomes_vertex = true;
        }
    }
    return result;
}

}  // namespace palpate
