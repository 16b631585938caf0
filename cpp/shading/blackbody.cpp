// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/blackbody.h"

#include <algorithm>
#include <cstddef>

namespace sluice {
namespace {

constexpr float coldest = 965, hottest = 12000;  // K, of the first and the last row

// As rendered by Cycles 3.4.1 at 33 temperatures evenly spaced in 1 / T from the hottest down to the coldest.
// Between them the colour is almost linear in 1 / T: the table is good to 3e-3.
constexpr Color rows[] = {
    {0.8263f, 0.9945f, 1.5663f}, {0.9102f, 0.9937f, 1.3274f}, {1.0057f, 0.9872f, 1.1087f},
    {1.1103f, 0.9758f, 0.9164f}, {1.2226f, 0.9592f, 0.7494f}, {1.3413f, 0.9379f, 0.6076f},
    {1.464f, 0.9135f, 0.4878f},  {1.5897f, 0.8869f, 0.3861f}, {1.7191f, 0.8567f, 0.3018f},
    {1.8505f, 0.8248f, 0.2308f}, {1.9831f, 0.7913f, 0.1716f}, {2.1166f, 0.7564f, 0.1225f},
    {2.2509f, 0.7206f, 0.0819f}, {2.3858f, 0.6839f, 0.0482f}, {2.5212f, 0.6465f, 0.0202f},
    {2.6555f, 0.6089f, 0},       {2.7902f, 0.5707f, 0},       {2.9237f, 0.5326f, 0},
    {3.056f, 0.4945f, 0},        {3.1874f, 0.4564f, 0},       {3.3179f, 0.4184f, 0},
    {3.4464f, 0.3808f, 0},       {3.5736f, 0.3435f, 0},       {3.6986f, 0.3067f, 0},
    {3.8218f, 0.2704f, 0},       {3.9432f, 0.2345f, 0},       {4.0621f, 0.1993f, 0},
    {4.1798f, 0.1644f, 0},       {4.2946f, 0.1303f, 0},       {4.4069f, 0.0969f, 0},
    {4.5169f, 0.0642f, 0},       {4.6247f, 0.0321f, 0},       {4.7306f, 0.0005f, 0},
};

}  // namespace

Color blackbody(float kelvin) noexcept {
  constexpr float hot = 1 / hottest, cold = 1 / coldest, last = std::size(rows) - 1;
  const float bounded = std::clamp(kelvin, coldest, hottest),
              x = std::clamp((1 / bounded - hot) / (cold - hot) * last, 0.0f, last);
  // No number (NaN) is of row 0 and stays no number.
  const auto row = std::min(static_cast<std::size_t>(std::max(0.0f, x)), std::size(rows) - 2);
  return rows[row] + (rows[row + 1] - rows[row]) * (x - static_cast<float>(row));
}

}  // namespace sluice
