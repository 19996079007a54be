/PROG  WRONG_OPTIONS
/ATTR
OWNER		= MNEDITOR;
DEFAULT_GROUP	= 1,*,*,*,*;
/MN
   1:  PR[1]=VR[1].OFFSET ;
   2:L P[1] 50mm/sec FINE VOFFSET,VR[1] ;
   3:  VISION RUN_FIND 'A' ;
   4:  OpenHand ;
   5:  IF DI[1]=ON+,JMP LBL[1] ;
   6:L P[1] 50mm/sec FINE DB 10mm,R[1]=1 INC ;
   7:L P[1] 50mm/sec FINE TB .1sec,CALL ACTION(1) ;
   8:L P[1] 50mm/sec FINE TA .1sec,JMP LBL[1] ;
   9:  LBL[R[1]] ;
  10:  R[1]=ABS[R[2] ;
  11:  IF ERR_NUM=1,JMP LBL[1] ;
  12:  SOFTFLOAT ;
  13:  STICK DETECT ;
  14:  R[1]=PULSE ;
  15:  LBL[1] ;
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
