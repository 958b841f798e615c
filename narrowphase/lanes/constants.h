#pragma once
#include "tolerances.h"
