/* Evidence for ADR 0003: first break-away and first arrival of the case 41 N, 0.02 m/s in 80-bit arithmetic (classical
   fourth-order Runge-Kutta, bisection), without and with the departure seed.
   cc -O2 -o departure 0003-departure.c -lm && ./departure      (x86-64: long double has 64 bits of mantissa) */
#include <stdio.h>
#include <math.h>
typedef long double L;
L F=41.0L,v0=0.02L; L w[2],D[2]={0.00015L,0.00085L},m=0.427L,ph[2]={2,-2};
L mu(L v){v=fabsl(v);return 0.66L*(0.5L+0.5L*expl(-v/0.02L))*(0.5L+0.5L*expl(-0.25L*v));}
static L acc0(const L*x,int j){return -2*D[j]*w[j]*x[2*j+1]-w[j]*w[j]*x[2*j];}
static L Fc(const L*x){L s=0,g=0;for(int j=0;j<2;j++){s+=ph[j]*acc0(x,j);g+=ph[j]*ph[j]/m;}return -s/g;}
static L vr(const L*x){return ph[0]*x[1]+ph[1]*x[3]-v0;}
static int mode;
static void f(const L*x,L*d){L fr= mode==0?Fc(x):-mode*mu(vr(x))*F; for(int j=0;j<2;j++){d[2*j]=x[2*j+1];d[2*j+1]=acc0(x,j)+ph[j]*fr/m;}}
static void rk(const L*x,L h,L*y){L k1[4],k2[4],k3[4],k4[4],t[4];f(x,k1);for(int i=0;i<4;i++)t[i]=x[i]+h/2*k1[i];f(t,k2);for(int i=0;i<4;i++)t[i]=x[i]+h/2*k2[i];f(t,k3);for(int i=0;i<4;i++)t[i]=x[i]+h*k3[i];f(t,k4);for(int i=0;i<4;i++)y[i]=x[i]+h/6*(k1[i]+2*k2[i]+2*k3[i]+k4[i]);}
int main(){L pi=acosl(-1.0L);w[0]=2*pi*80;w[1]=2*pi*510;
 for(int seed=0;seed<2;seed++) for(L h=1e-6L;h>2e-8L;h/=4){L x[4]={0.00047655585258591504L,0.01L,-1.1726095565358924e-05L,0},y[4],t=0;
  mode=0; /* to break-away */
  for(;;){rk(x,h,y); if(fabsl(Fc(y))>0.66L*F)break; for(int i=0;i<4;i++)x[i]=y[i]; t+=h;}
  L a=0,b=h;for(int i=0;i<80;i++){L c=(a+b)/2;rk(x,c,y);if(fabsl(Fc(y))>0.66L*F)b=c;else a=c;}
  rk(x,b,y);for(int i=0;i<4;i++)x[i]=y[i];t+=b;L tb=t;
  mode=Fc(x)>0?-1:1; if(seed){ L target=mode*1e-13L; /* shared between the modes as by an impulse at the tip */ L e=(target-vr(x))/8; x[1]+=ph[0]*e;x[3]+=ph[1]*e; }
  L T0=t; long n=0; for(;;){rk(x,h,y); if(n>100 && mode*vr(y)<0)break; for(int i=0;i<4;i++)x[i]=y[i]; t+=h;n++; if(t>0.05L)break;}
  a=0;b=h;for(int i=0;i<80;i++){L c=(a+b)/2;rk(x,c,y);if(mode*vr(y)<0)b=c;else a=c;}
  printf("seed %d h %.2Le break %.19Lf arrival %.19Lf\n",seed,h,tb,t+b);}
}
