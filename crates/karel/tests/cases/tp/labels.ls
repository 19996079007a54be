/PROG  -LABELS_BCKED8-
/ATTR
OWNER		= MNEDITOR;
DEFAULT_GROUP	= 1,*,*,*,*;
/MN
   1:  R[1]=2 ;
   2:  JMP LBL[R[1]:which] ;
   3:  R[9]=99 ;
   4:  LBL[2:the [2]nd] ;
   5:  --dn:pgri[3] ;
   6:  R[2:twice]=R[2:twice]+1 ;
   7:  IF R[2]<2,JMP LBL[R[1]] ;
   8:  IF (R[2]=2),DO[1]=PULSE,0.1sec ;
   9:  SELECT R[2]=2,JMP LBL[4] ;
  10:         =3,JMP LBL[7] ;
  11:  LBL[4] ;
  12:  OVERRIDE=R[2] ;
  13:  MESSAGE[DO[81] is ON.] ;
  14:  F[5:UI[5]]=(ON) ;
  15:  SOFTFLOAT[3] ;
  16:  SOFTFLOAT END ;
  17:  FOLLOW UP ;
  18:  COL GUARD ADJUST R[1] ;
  19:  COL GUARD OFF ;
  20:  STICK DETECT ON ;
  21:  JMP LBL[777] ;
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
