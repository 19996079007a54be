/PROG  _LABEL_BY
/ATTR
OWNER		= MNEDITOR;
DEFAULT_GROUP	= 1,*,*,*,*;
/MN
   1:  R[1]=3 ;
   2:  LBL[1] ;
   3:  JMP LBL[R[1]] ;
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
