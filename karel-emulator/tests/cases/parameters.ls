/PROG  PARAMETERS
/ATTR
OWNER = MNEDITOR;
/MN
   1:  !--> load asks.kl ;
   2:  !--> load helper.ls ;
   3:  !--> load helper3.ls ;
   4:  !--> set DIN[1]=ON ;
   5:  R[1:count]=7    ;
   6:  SR[1]='grip'    ;
   7:  CALL ASKS(R[1],1.5,SR[1]) ;
   8:  CALL HELPER(1,R[1]) ;
   9:  RUN HELPER3 ;
  10:  R[2]=R[1] DIV 2    ;
  11:  R[3]=R[1] MOD 2    ;
  12:  IF (DI[1]=ON AND !DI[2] OR R[1]<>7) THEN ;
  13:  DO[1]=ON ;
  14:  ELSE ;
  15:  DO[2]=ON ;
  16:  ENDIF ;
  17:  FOR R[4]=1 TO 3 ;
  18:  SELECT R[4]=1,JMP LBL[1] ;
  19:         =2,CALL HELPER(5,R[4]) ;
  20:         ELSE,JMP LBL[1] ;
  21:  LBL[1:next] ;
  22:  ENDFOR ;
  23:  IF R[2]=3,JMP LBL[2] ;
  24:  ABORT ;
  25:  LBL[2] ;
  26:  RO[1]=DI[1]    ;
  27:  GO[1]=GI[1]    ;
  28:  AO[1]=AI[1]    ;
  29:  F[1]=(RI[1] OR SI[1] OR UI[1])    ;
  30:  F[2]=(SO[1] AND UO[1])    ;
  31:  DO[3]=PULSE,0.1sec ;
  32:  OVERRIDE=50% ;
  33:  MESSAGE[half speed] ;
  34:  PAYLOAD[1] ;
  35:  $WAITTMOUT=100 ;
  36:  WAIT DI[2]=ON TIMEOUT,LBL[3] ;
  37:  DO[4]=ON ;
  38:  LBL[3] ;
  39:  WAIT   .10(sec) ;
  40:  PAUSE ;
/POS
/END
