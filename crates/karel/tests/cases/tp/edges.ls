/PROG  EDGES
/ATTR
OWNER		= MNEDITOR;
DEFAULT_GROUP	= 1,*,*,*,*;
/MN
   1:  DO[1]=PULSE,0.1sec ;
   2:  WAIT DO[1]=OFF- ;
   3:  R[1]=1 ;
   4:  WAIT DO[1]=ON+ TIMEOUT,LBL[1] ;
   5:  R[2]=99 ;
   6:  LBL[1] ;
   7:  SKIP CONDITION DO[3]=ON+ ;
   8:L P[1] 50mm/sec FINE Skip,LBL[2] TB .01sec,DO[3]=ON ;
   9:  R[3]=1 ;
  10:  LBL[2] ;
  11:  DO[3]=OFF ;
  12:L P[2] 50mm/sec FINE SkipJump,LBL[3] TB .01sec,DO[3]=ON ;
  13:  R[4]=99 ;
  14:  LBL[3] ;
  15:  WAIT ERR_NUM=12311 OR DO[1]=OFF ;
  16:  R[5]=1 ;
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
P[3:"never taught"]{
   GP1:
	UF : 0, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X = ********  mm,	Y = ********  mm,	Z = ********  mm,
	W = ******** deg,	P = ******** deg,	R = ******** deg
};
P[4]{
   GP1:
	UF : F, UT : F,
	J1 = ******** deg,	J2 = 20.000 deg,	J3 = -30.000 deg,	J4 = 0.000 deg,	J5 = -60.000 deg,	J6 = 5.000 deg
};
/END
