/PROG  WRONG
/ATTR
OWNER		= MNEDITOR;
DEFAULT_GROUP	= 1,*,*,*,*;
/MN
   1:  R[1]=1 ;
   2:  A P[1] 100mm/sec FINE ;
   3:J P[1] 100mm/sec FINE ;
   4:J P[1] 20% FINE Wjnt ;
   5:C P[1]
    :  P[2] 10mm/sec FINE INC ;
   6:L P[1] 20% FINE ;
   7:L P[1] 20mm/sec CNT101 ;
   8:L P[1] 20mm/sec FINE TB .10sec,CALL ACTION ;
   9:L P[1] 20mm/sec FINE EV50% ;
  10:L P[1] 20mm/sec FINE Skip,LBL[1],PR[1]=P[1] ;
  11:  TIMER[1]=GO ;
  12:  TIMER[1]=5 ;
  13:  COL GUARD ADJUST 100 ;
  14:  ERROR_PROG=ACTION ;
  15:  RESUME_PROG=ACTION ;
  16:  JOINT_MAX_SPEED[1]=50 ;
  17:  LINEAR_MAX_SPEED=500 ;
  18:  RSR[1]=ENABLE ;
  19:  MONITOR ;
  20:  WHEN R[1]=1,JMP LBL[1] ;
  21:  COL DETECT MAYBE ;
  22:  DI[1]=PULSE ;
  23:  PR[1]=PULSE,1sec ;
  24:  POINT_LOGIC ;
  25:  LBL[1] ;
/POS
P[1:"here"]{
   GP1:
	UF : 0, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X = 900.000 mm,	Y = 0.000 mm,	Z = 700.000 mm,
	W = 180.000 deg,	P = 0.000 deg,	R = 0.000 deg
};
P[2:"here"]{
   GP1:
	UF : 0, UT : 1,		CONFIG : 'F U T, 0, 0, -1',
	X = 800.000 mm,	Y = 100.000 mm,	Z = 600.000 mm,
	W = 180.000 deg,	P = 0.000 deg,	R = 0.000 deg
};
P[3]{
   GP1:
	UF : F, UT : F,
	J1 = 10.000 deg,	J2 = 20.000 deg,	J3 = -30.000 deg,	J4 = 0.000 deg,	J5 = -60.000 deg,	J6 = 5.000 deg
};
/END
