// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "content_store/anchor_store.h"
#include "tests/bench/anchors/city.h"

namespace waymark::bench {

double SecondsSince(std::chrono::steady_clock::time_point begin);
/// Sorts the values, of which there is one.
double Quantile(std::vector<double>& values, double q);

/// Creates them and requires that all were new.
void CreateIn(content::AnchorStore& store, std::span<const content::AnchorRecord> records);

/// Prints how fast groups are created by the store and by hand: by a row and no more, and by all
/// the facts that the store keeps. The ways by hand are tables of a PostgreSQL, or files beside the
/// one of SQLite, and are filled first to as many anchors as the store has, for an index that still
/// fits the database's memory is another task than one that does not. Rounds of all three, one
/// after the other in turning order, so that a busy machine slows all; groups of 16, 64 and
/// `group`. Then how fast many threads create, each one after the other: they share commits.
void MeasureCreates(content::AnchorStore& store, const std::string& location, const City& city,
                    std::uint64_t anchors, std::size_t group, std::size_t fill_group);

}  // namespace waymark::bench
