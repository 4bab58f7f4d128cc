#pragma once
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#include <x86intrin.h>
#include <cstdio>
struct Ticks { const char* n[40]; unsigned long long t[40]; int c[40]; int k=0;
 int Get(const char* s){ for(int i=0;i<k;++i) if(n[i]==s) return i; n[k]=s;t[k]=0;c[k]=0; return k++; }
 void Print(double per){ for(int i=0;i<k;++i) std::fprintf(stderr,"  %-22s %9.3f us/submap x%d\n",n[i],t[i]/per,c[i]); k=0; } };
inline Ticks ticks;
struct Tick { int i; unsigned long long b; Tick(const char* s):i(ticks.Get(s)),b(__rdtsc()){} ~Tick(){ ticks.t[i]+=__rdtsc()-b; ticks.c[i]++; } };
